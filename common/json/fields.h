// Maps a record's fields to members of a JSON object. One function lists the fields for reading and
// writing:
//
//   template <class Visit, class Change>
//   void change_fields(Visit& visit, Change& change) {
//     visit("number", change.number);
//     visit.as("from", change.from, name_of, state_of);  // an enumeration by its name
//     visit.part("counts", change.counts, counts_fields);
//   }
//
// FieldWriter writes the fields in order. FieldReader throws Error for a value of the wrong kind.
//
// Thread safety: each object belongs to one thread.
#pragma once

#include <optional>
#include <string>
#include <type_traits>

#include "common/json/value.h"

namespace sleight::json {

/// How an empty optional is written, and how a missing field is read.
enum class None {
  left_out,  ///< a missing field keeps its value
  null       ///< a missing field is an Error
};

class FieldWriter {
 public:
  /// REQUIRES: `object` is an object or null.
  FieldWriter(Value& object, None none) : object_(object), none_(none) {}

  template <class T>
  void operator()(const char* name, const T& value) {
    if constexpr (requires { typename T::representation; }) {
      object_[name] = value.value;
    } else {
      object_[name] = value;
    }
  }
  template <class T>
  void operator()(const char* name, const std::optional<T>& value) {
    if (value) return (*this)(name, *value);
    if (none_ == None::null) object_[name] = nullptr;
  }
  /// Stores to(value).
  template <class T, class To, class Of>
  void as(const char* name, const T& value, const To& to, const Of&) {
    object_[name] = to(value);
  }
  template <class T, class To, class Of>
  void as(const char* name, const std::optional<T>& value, const To& to, const Of& of) {
    if (value) return as(name, *value, to, of);
    if (none_ == None::null) object_[name] = nullptr;
  }
  template <class T, class Fields>
  void part(const char* name, const T& value, const Fields& fields) {
    FieldWriter inner(object_[name], none_);
    fields(inner, value);
  }
  template <class T, class Fields>
  void part(const char* name, const std::optional<T>& value, const Fields& fields) {
    if (value) return part(name, *value, fields);
    if (none_ == None::null) object_[name] = nullptr;
  }

 private:
  Value& object_;
  None none_;
};

class FieldReader {
 public:
  /// Throws Error if `object` is not an object.
  FieldReader(const Value& object, None none) : object_(object), none_(none) {
    static_cast<void>(object.items());
  }

  template <class T>
  void operator()(const char* name, T& value) {
    read(name, value, [](const Value& found, auto& to) { assign(found, to); });
  }
  /// `of` converts a stored value to an optional. Empty: the value is unknown.
  template <class T, class To, class Of>
  void as(const char* name, T& value, const To&, const Of& of) {
    read(name, value, [&](const Value& found, auto& to) {
      using Stored = std::invoke_result_t<To, decltype(to)>;
      auto known =
          of(found.get<std::conditional_t<std::is_arithmetic_v<Stored>, Stored, std::string>>());
      if (!known) throw Error("unknown value " + found.dump());
      to = *std::move(known);
    });
  }
  template <class T, class Fields>
  void part(const char* name, T& value, const Fields& fields) {
    read(name, value, [&](const Value& found, auto& to) {
      FieldReader inner(found, none_);
      fields(inner, to);
    });
  }

 private:
  template <class T>
  static void assign(const Value& found, T& value) {
    if constexpr (requires { typename T::representation; }) {
      value.value = found.get<typename T::representation>();
    } else {
      value = found.get<T>();
    }
  }
  template <class T, class Assign>
  void read(const char* name, T& value, const Assign& assign) {
    const Value* found = none_ == None::null ? &object_.at(name) : object_.find(name);
    if (found) assign(*found, value);
  }
  template <class T, class Assign>
  void read(const char* name, std::optional<T>& value, const Assign& assign) {
    const Value* found = none_ == None::null ? &object_.at(name) : object_.find(name);
    if (!found) return;
    value.reset();
    if (none_ == None::left_out || !found->is_null()) assign(*found, value.emplace());
  }

  const Value& object_;
  None none_;
};

}  // namespace sleight::json
