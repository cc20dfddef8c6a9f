// Unpacks a packed answer, as the page does.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "common/json/value.h"

namespace sleight::gallery::testing {

struct Unpacked {
  json::Value head{};
  json::Value columns{};
  std::string_view bytes{};

  template <class Element>
  std::vector<Element> column(const std::string& name) const {
    for (const json::Value& one : columns.elements()) {
      if (one["name"] != name) continue;
      std::vector<Element> elements(one["count"].get<std::size_t>());
      const auto offset = one["offset"].get<std::size_t>();
      EXPECT_EQ(offset % 8, 0U);
      EXPECT_LE(offset + elements.size() * sizeof(Element), bytes.size());
      if (!elements.empty())
        std::memcpy(elements.data(), bytes.data() + offset, elements.size() * sizeof(Element));
      return elements;
    }
    ADD_FAILURE() << "no column " << name;
    return {};
  }
};

inline Unpacked unpacked(std::string_view whole) {
  std::uint32_t length = 0;
  EXPECT_GE(whole.size(), sizeof length);
  std::memcpy(&length, whole.data(), sizeof length);
  EXPECT_EQ((length + sizeof length) % 8, 0U);
  const auto json = json::Value::parse(whole.substr(sizeof length, length));
  return {.head = json["head"],
          .columns = json["columns"],
          .bytes = whole.substr(sizeof length + length)};
}

}  // namespace sleight::gallery::testing
