#include "common/archive/remote/messages.h"

#include <cstring>
#include <utility>

#include "common/archive/limits.h"
#include "common/base/check.h"

namespace sleight::archive::remote {
namespace {

class Composer {
 public:
  template <class T>
  void put(T value) {
    writer_.put(value);
  }
  void put_text(std::string_view text) {
    writer_.put(static_cast<std::uint32_t>(text.size()));
    for (const char c : text)
      writer_.put(c);
  }
  base::Bytes take() { return writer_.take(); }

 private:
  base::ByteWriter writer_;
};

/// The reverse of Composer. Reads a message. If data are missing, returns 0 or empty values and
/// sets `failed`.
class Decomposer {
 public:
  explicit Decomposer(base::BytesView bytes) : rest_(bytes) {}

  template <class T>
  T get() {
    T value{};
    const base::BytesView part = take(sizeof(T));
    if (!failed_) std::memcpy(&value, part.data(), sizeof(T));
    return value;
  }
  std::string get_text(std::uint64_t bytes_max) {
    const auto size = get<std::uint32_t>();
    if (size > bytes_max) failed_ = true;
    const base::BytesView part = take(size);
    return failed_ ? std::string()
                   : std::string(reinterpret_cast<const char*>(part.data()), part.size());
  }
  std::uint32_t get_count(std::uint64_t most) {
    const auto count = get<std::uint32_t>();
    if (count > most) failed_ = true;
    return failed_ ? 0 : count;
  }
  void fail() { failed_ = true; }
  bool failed() const { return failed_; }
  bool is_done() const { return !failed_ && rest_.empty(); }

 private:
  base::BytesView take(std::size_t size) {
    if (failed_ || size > rest_.size()) {
      failed_ = true;
      return {};
    }
    const base::BytesView part = rest_.first(size);
    rest_ = rest_.subspan(size);
    return part;
  }

  base::BytesView rest_;
  bool failed_ = false;
};

/// The type of the value that follows, as an index into the alternatives of Attribute::value.
enum class AttributeKind : std::uint8_t { integer = 0, number = 1, text = 2 };

void put_attributes(const std::vector<Attribute>& attributes, Composer& to) {
  to.put(static_cast<std::uint32_t>(attributes.size()));
  for (const Attribute& attribute : attributes) {
    to.put_text(attribute.name);
    to.put(static_cast<std::uint8_t>(attribute.value.index()));
    if (const auto* integer = std::get_if<std::int64_t>(&attribute.value)) {
      to.put(*integer);
    } else if (const auto* number = std::get_if<double>(&attribute.value)) {
      to.put(*number);
    } else {
      to.put_text(std::get<std::string>(attribute.value));
    }
  }
}

std::vector<Attribute> get_attributes(Decomposer& from) {
  std::vector<Attribute> attributes;
  for (std::uint32_t left = from.get_count(k_attributes_max); left > 0; --left) {
    Attribute attribute{.name = from.get_text(k_attribute_bytes_max), .value = std::int64_t{0}};
    switch (static_cast<AttributeKind>(from.get<std::uint8_t>())) {
      case AttributeKind::integer:
        attribute.value = from.get<std::int64_t>();
        break;
      case AttributeKind::number:
        attribute.value = from.get<double>();
        break;
      case AttributeKind::text:
        attribute.value = from.get_text(k_attribute_bytes_max);
        break;
      default:
        from.fail();
    }
    if (from.failed()) return {};
    attributes.push_back(std::move(attribute));
  }
  return attributes;
}

void put_dataset(const DatasetSpec& spec, Composer& to) {
  to.put_text(spec.name);
  to.put(static_cast<std::uint8_t>(spec.type));
  to.put(static_cast<std::uint64_t>(spec.text_bytes));
  to.put(static_cast<std::uint32_t>(spec.dims.size()));
  for (const Dimension& dim : spec.dims) {
    to.put_text(dim.name);
    to.put(static_cast<std::uint64_t>(dim.size));
  }
  put_attributes(spec.attributes, to);
}

DatasetSpec get_dataset(Decomposer& from) {
  DatasetSpec spec{.name = from.get_text(k_attribute_bytes_max)};
  const auto type = from.get<std::uint8_t>();
  if (type > static_cast<std::uint8_t>(ElementType::text)) from.fail();
  spec.type = from.failed() ? ElementType::f64 : static_cast<ElementType>(type);
  spec.text_bytes = from.get<std::uint64_t>();
  for (std::uint32_t left = from.get_count(k_objects_max); left > 0 && !from.failed(); --left) {
    std::string name = from.get_text(k_attribute_bytes_max);
    spec.dims.push_back({std::move(name), from.get<std::uint64_t>()});
  }
  spec.attributes = get_attributes(from);
  return spec;
}

}  // namespace

QuestionBytes encode(const Question& question) {
  QuestionBytes bytes{};
  std::memcpy(bytes.data(), &question.number, 4);
  std::memcpy(bytes.data() + 4, &question.dataset, 4);
  std::memcpy(bytes.data() + 8, &question.first, 8);
  std::memcpy(bytes.data() + 16, &question.count, 8);
  return bytes;
}

Question decode_question(const QuestionBytes& bytes) {
  Question question;
  std::memcpy(&question.number, bytes.data(), 4);
  std::memcpy(&question.dataset, bytes.data() + 4, 4);
  std::memcpy(&question.first, bytes.data() + 8, 8);
  std::memcpy(&question.count, bytes.data() + 16, 8);
  return question;
}

HeadBytes encode(const AnswerHead& head) {
  HeadBytes bytes{};
  std::memcpy(bytes.data(), &head.number, 4);
  std::memcpy(bytes.data() + 4, &head.kind, 1);
  std::memcpy(bytes.data() + 5, &head.type, 1);
  std::memcpy(bytes.data() + 6, &head.nothing, 2);
  std::memcpy(bytes.data() + 8, &head.bytes, 8);
  return bytes;
}

AnswerHead decode_head(const HeadBytes& bytes) {
  AnswerHead head;
  std::uint8_t kind = 0;
  std::memcpy(&head.number, bytes.data(), 4);
  std::memcpy(&kind, bytes.data() + 4, 1);
  head.kind = static_cast<AnswerKind>(kind);
  std::memcpy(&head.type, bytes.data() + 5, 1);
  std::memcpy(&head.nothing, bytes.data() + 6, 2);
  std::memcpy(&head.bytes, bytes.data() + 8, 8);
  return head;
}

base::Bytes encode_contents(const std::vector<Group>& groups) {
  Composer to;
  to.put(static_cast<std::uint32_t>(groups.size()));
  for (const Group& group : groups) {
    to.put_text(group.name);
    put_attributes(group.attributes, to);
    to.put(static_cast<std::uint32_t>(group.datasets.size()));
    for (const DatasetSpec& spec : group.datasets)
      put_dataset(spec, to);
  }
  return to.take();
}

base::Result<std::vector<Group>, std::string> decode_contents(base::BytesView bytes) {
  Decomposer from(bytes);
  std::vector<Group> groups;
  for (std::uint32_t left = from.get_count(k_objects_max); left > 0 && !from.failed(); --left) {
    Group group{.name = from.get_text(k_attribute_bytes_max)};
    group.attributes = get_attributes(from);
    for (std::uint32_t more = from.get_count(k_objects_max); more > 0 && !from.failed(); --more)
      group.datasets.push_back(get_dataset(from));
    groups.push_back(std::move(group));
  }
  if (!from.is_done()) return std::string("the list of contents is malformed");
  return groups;
}

base::Bytes encode_texts(const std::vector<std::string>& texts) {
  Composer to;
  for (const std::string& text : texts)
    to.put_text(text);
  return to.take();
}

base::Result<std::vector<std::string>, std::string> decode_texts(base::BytesView bytes,
                                                                 std::uint64_t count,
                                                                 std::uint64_t text_bytes) {
  Decomposer from(bytes);
  std::vector<std::string> texts;
  for (std::uint64_t left = count; left > 0 && !from.failed(); --left)
    texts.push_back(from.get_text(text_bytes));
  if (!from.is_done()) return std::string("the texts are malformed");
  return texts;
}

std::uint64_t texts_bytes_max(std::uint64_t count, std::uint64_t text_bytes) {
  std::uint64_t bytes = 0;
  if (__builtin_add_overflow(text_bytes, sizeof(std::uint32_t), &bytes) ||
      __builtin_mul_overflow(bytes, count, &bytes))
    return ~std::uint64_t{0};
  return bytes;
}

std::size_t size_of(ElementType type) {
  switch (type) {
    case ElementType::f64:
    case ElementType::i64:
      return 8;
    case ElementType::i32:
      return 4;
    case ElementType::boolean:
      return 1;
    case ElementType::text:
      break;
  }
  base::check_failed("the element type has a fixed size", std::string(name_of(type)));
}

}  // namespace sleight::archive::remote
