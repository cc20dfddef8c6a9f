#include "common/archive/specs.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "common/archive/format.h"
#include "common/archive/text.h"
#include "common/base/check.h"

namespace sleight::archive {

std::int64_t signed_of(std::uint64_t value) {
  CHECK_LE(value, static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max()));
  return static_cast<std::int64_t>(value);
}

std::int32_t small_of(std::uint64_t value) {
  CHECK_LE(value, static_cast<std::uint64_t>(std::numeric_limits<std::int32_t>::max()));
  return static_cast<std::int32_t>(value);
}

DatasetSpec spec_of(std::string name, ElementType type, Dims dims, std::string long_name,
                    std::string units) {
  DatasetSpec spec{.name = std::move(name), .type = type, .dims = std::move(dims)};
  spec.attributes = {{"long_name", std::move(long_name)}, {"units", std::move(units)}};
  return spec;
}

void write_coordinate(Sink& sink, std::string_view group, const Dimension& dim,
                      std::string long_name, std::uint64_t step) {
  Column<std::int64_t> column(sink, group,
                              spec_of(dim.name, ElementType::i64, {dim}, std::move(long_name)));
  for (std::size_t i = 0; i < dim.size; ++i)
    column.push(signed_of(i * step));
  column.flush();
}

namespace {

void write_index_names(Sink& sink, std::string_view group, const Dimension& dim) {
  CHECK_EQ(dim.names.size(), dim.size);
  for (const std::string& name : dim.names) {
    CHECK(!name.empty());
    CHECK_LE(name.size(), k_index_name_bytes_max);
  }
  write_words(sink, group, dim.name, {dim}, "name of the " + dim.name, dim.names);
}

}  // namespace

void write_own_coordinates(Sink& sink, std::string_view group,
                           const std::vector<Variable>& variables, Dims& written) {
  for (const Variable& variable : variables) {
    for (const Dimension& dim : variable.dims) {
      const auto same = std::ranges::find(written, dim.name, &Dimension::name);
      if (same != written.end()) {
        CHECK_EQ(same->size, dim.size);
        CHECK(same->names == dim.names);
        continue;
      }
      written.push_back(dim);
      if (dim.names.empty())
        write_coordinate(sink, group, dim, "index of the " + dim.name);
      else
        write_index_names(sink, group, dim);
    }
  }
}

void write_words(Sink& sink, std::string_view group, const std::string& name, const Dims& dims,
                 const std::string& long_name, std::span<const std::string> words) {
  DatasetSpec spec{.name = name, .type = ElementType::text, .dims = dims};
  spec.attributes = {{"long_name", long_name}};
  for (const std::string& word : words) {
    CHECK(is_clean_line(word));
    spec.text_bytes = std::max(spec.text_bytes, word.size());
  }
  const Sink::DatasetHandle dataset = sink.create_dataset(group, spec);
  sink.append(dataset, words);
}

DensityColumns::DensityColumns(Sink& sink, std::string_view group, const Dims& leading)
    : log_prior_(sink, group,
                 spec_of("log_prior", ElementType::f64, leading,
                         "log density of the state under the world's prior")),
      log_constraint_(sink, group,
                      spec_of("log_constraint", ElementType::f64, leading,
                              "log density of the constraint at the outcome")) {}

}  // namespace sleight::archive
