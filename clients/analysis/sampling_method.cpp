#include "clients/analysis/sampling_method.h"

#include "common/archive/format.h"
#include "common/request/document.h"

namespace sleight::analysis {

using request::Method;

namespace {

template <typename T>
std::optional<T> sampler_value(std::string_view request_text, std::string_view key) {
  const auto document = request::parse_document(request_text, "request");
  if (!document) return std::nullopt;
  const request::Section* sampler = document.value().find("sampler");
  const request::Entry* entry = sampler == nullptr ? nullptr : sampler->find(key);
  const T* value = entry == nullptr ? nullptr : std::get_if<T>(&entry->value.held);
  return value == nullptr ? std::nullopt : std::optional(*value);
}

}  // namespace

std::optional<Method> method_of(std::string_view request_text) {
  const auto name = sampler_value<std::string>(request_text, "method");
  if (!name) return std::nullopt;
  if (*name == "metropolis_hastings") return Method::metropolis_hastings;
  if (*name == "parallel_tempering") return Method::parallel_tempering;
  if (*name == "simulated_tempering") return Method::simulated_tempering;
  if (*name == "tempered_transitions") return Method::tempered_transitions;
  if (*name == "annealed_importance") return Method::annealed_importance;
  if (*name == "sequential") return Method::sequential;
  if (*name == "splitting") return Method::splitting;
  if (*name == "search") return Method::search;
  return std::nullopt;
}

std::string method_word(std::string_view request_text) {
  return sampler_value<std::string>(request_text, "method").value_or("");
}

bool burns_in(std::optional<Method> method) {
  return method == Method::simulated_tempering || method == Method::tempered_transitions ||
         method == Method::annealed_importance;
}

bool draws_are_burnt_in(const archive::Source& source, std::optional<Method> method) {
  const archive::Group* learnt = archive::find_group(source, archive::k_tempering);
  const bool has_tours = learnt != nullptr && archive::find_dataset(*learnt, "tour_begin");
  return has_tours || (method && request::makes_islands(*method));
}

std::optional<std::int64_t> tour_scans_of(std::string_view request_text) {
  return sampler_value<std::int64_t>(request_text, "tour_scans");
}

}  // namespace sleight::analysis
