
#include <algorithm>
#include <ostream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "common/json/value.h"

namespace sleight::json {

using Library = nlohmann::ordered_json;

/// Converts values to the library's type and back. Keys are unique in both types. So members are
/// appended directly; the types' operators would first look up the key.
struct Conversion {
  static Library library(const Value& value) { return std::visit(Conversion(), value.value_); }
  static Value value(const Library& read, int depth);

  template <class Plain>
  Library operator()(const Plain& plain) const {
    return plain;
  }
  Library operator()(const Value::Array& elements) const {
    Library array = Library::array();
    for (const Value& element : elements)
      array.push_back(library(element));
    return array;
  }
  Library operator()(const Value::Object& members) const {
    Library::object_t object;
    for (const auto& [key, member] : members)
      object.push_back({key, library(member)});
    return object;
  }
};

Value Conversion::value(const Library& read, int depth) {
  if (depth > k_depth_max)
    throw Error(fmt::format("the JSON text is nested more than {} levels deep", k_depth_max));
  switch (read.type()) {
    case Library::value_t::boolean:
      return read.get<bool>();
    case Library::value_t::number_integer:
      return read.get<std::int64_t>();
    case Library::value_t::number_unsigned:
      return read.get<std::uint64_t>();
    case Library::value_t::number_float:
      return read.get<double>();
    case Library::value_t::string:
      return read.get_ref<const std::string&>();
    case Library::value_t::array: {
      Value::Array elements;
      for (const Library& element : read)
        elements.push_back(value(element, depth + 1));
      Value array;
      array.value_ = std::move(elements);
      return array;
    }
    case Library::value_t::object: {
      Value::Object members;
      for (const auto& [key, member] : read.get_ref<const Library::object_t&>())
        members.push_back({key, value(member, depth + 1)});
      Value object;
      object.value_ = std::move(members);
      return object;
    }
    default:
      return nullptr;
  }
}

namespace {

bool is_pair(const Value& value) {
  return value.is_array() && value.size() == 2 && value[0].is_string();
}

}  // namespace

Value::Value() : value_(nullptr) {}
Value::Value(std::nullptr_t) : value_(nullptr) {}
Value::Value(double value) : value_(value) {}
Value::Value(const char* text) : value_(std::string(text)) {}
Value::Value(std::string_view text) : value_(std::string(text)) {}
Value::Value(std::string text) : value_(std::move(text)) {}
Value::Value(const Value& other) = default;
Value::Value(Value&& other) noexcept = default;
Value& Value::operator=(const Value& other) = default;
Value& Value::operator=(Value&& other) noexcept = default;
Value::~Value() = default;

Value::Value(Whole whole) : value_(nullptr) {
  if (whole.is_flag) {
    value_ = whole.flag;
  } else if (whole.is_negative) {
    value_ = static_cast<std::int64_t>(whole.bits);
  } else {
    value_ = whole.bits;
  }
}

Value::Value(std::initializer_list<Value> elements) : Value(array(elements)) {
  if (!std::ranges::all_of(elements, is_pair)) return;
  Value made = object();
  for (const Value& pair : elements)
    made[pair[0].text()] = pair[1];
  *this = std::move(made);
}

Value Value::array() {
  Value made;
  made.value_ = Array();
  return made;
}

Value Value::array(std::initializer_list<Value> elements) {
  Value made;
  made.value_ = Array(elements);
  return made;
}

Value Value::object() {
  Value made;
  made.value_ = Object();
  return made;
}

Value Value::parse(std::string_view text) {
  try {
    return Conversion::value(Library::parse(text), 0);
  } catch (const Library::exception& error) {
    throw Error(error.what());
  }
}

Value Value::parse_or_null(std::string_view text) {
  try {
    return parse(text);
  } catch (const Error&) {
    return nullptr;
  }
}

std::string Value::dump(int indent, bool is_ascii) const {
  return Conversion::library(*this).dump(indent, ' ', is_ascii, Library::error_handler_t::replace);
}

bool Value::is_null() const {
  return std::holds_alternative<std::nullptr_t>(value_);
}
bool Value::is_boolean() const {
  return std::holds_alternative<bool>(value_);
}
bool Value::is_whole() const {
  return std::holds_alternative<std::uint64_t>(value_);
}
bool Value::is_string() const {
  return std::holds_alternative<std::string>(value_);
}
bool Value::is_array() const {
  return std::holds_alternative<Array>(value_);
}
bool Value::is_object() const {
  return std::holds_alternative<Object>(value_);
}
bool Value::is_number() const {
  return is_whole() || std::holds_alternative<std::int64_t>(value_) ||
         std::holds_alternative<double>(value_);
}

void Value::refuse(const char* expected) const {
  throw Error(fmt::format("{} is not {}", dump().substr(0, 100), expected));
}

bool Value::flag() const {
  const bool* value = std::get_if<bool>(&value_);
  if (!value) refuse("true or false");
  return *value;
}

Value::Whole Value::whole() const {
  if (const auto* value = std::get_if<std::uint64_t>(&value_)) return {.bits = *value};
  const auto* value = std::get_if<std::int64_t>(&value_);
  if (!value) refuse("an integer");
  return {.bits = static_cast<std::uint64_t>(*value), .is_negative = true};
}

double Value::number() const {
  if (const auto* value = std::get_if<double>(&value_)) return *value;
  const Whole read = whole();
  return read.is_negative ? static_cast<double>(static_cast<std::int64_t>(read.bits))
                          : static_cast<double>(read.bits);
}

std::vector<std::string> Value::keys() const {
  std::vector<std::string> keys;
  for (const auto& [key, value] : items())
    keys.push_back(key);
  return keys;
}

const std::string& Value::text() const {
  const auto* value = std::get_if<std::string>(&value_);
  if (!value) refuse("a string");
  return *value;
}

const Value::Array& Value::elements() const {
  const auto* value = std::get_if<Array>(&value_);
  if (!value) refuse("an array");
  return *value;
}

const Value::Object& Value::items() const {
  const auto* value = std::get_if<Object>(&value_);
  if (!value) refuse("an object");
  return *value;
}

std::size_t Value::size() const {
  if (is_array()) return elements().size();
  if (is_object()) return items().size();
  return is_null() ? 0 : 1;
}

const Value* Value::find(std::string_view key) const {
  if (!is_object()) return nullptr;
  const auto found = std::ranges::find(items(), key, &Member::key);
  return found == items().end() ? nullptr : &found->value;
}

const Value& Value::at(std::string_view key) const {
  const Value* found = find(key);
  if (!found) throw Error(fmt::format("the key '{}' is missing", key));
  return *found;
}

const Value& Value::at(std::size_t index) const {
  if (index >= elements().size())
    throw Error(fmt::format("no element {} in an array of {}", index, size()));
  return elements()[index];
}

Value& Value::operator[](std::string_view key) {
  if (is_null()) value_ = Object();
  if (const Value* found = find(key)) return const_cast<Value&>(*found);
  auto* members = std::get_if<Object>(&value_);
  if (!members) refuse("an object");
  return members->emplace_back(std::string(key), Value()).value;
}

std::string Value::value(std::string_view key, const char* otherwise) const {
  return value(key, std::string(otherwise));
}

void Value::push_back(Value element) {
  if (is_null()) value_ = Array();
  auto* array = std::get_if<Array>(&value_);
  if (!array) refuse("an array");
  array->push_back(std::move(element));
}

void Value::erase(std::string_view key) {
  if (auto* members = std::get_if<Object>(&value_))
    std::erase_if(*members, [key](const Member& member) { return member.key == key; });
}

void Value::update(const Value& other) {
  for (const auto& [key, value] : other.items())
    (*this)[key] = value;
}

bool operator==(const Value& a, const Value& b) {
  if (a.value_.index() != b.value_.index())
    return a.is_number() && b.is_number() && a.get<double>() == b.get<double>();
  if (!a.is_object()) return a.value_ == b.value_;
  return a.size() == b.size() && std::ranges::all_of(a.items(), [&](const Value::Member& member) {
           const Value* other = b.find(member.key);
           return other && *other == member.value;
         });
}

std::ostream& operator<<(std::ostream& out, const Value& value) {
  return out << value.dump();
}

}  // namespace sleight::json
