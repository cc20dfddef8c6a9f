#include "clients/gallery_server/answers.h"

#include <algorithm>
#include <charconv>
#include <optional>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "clients/gallery_server/archive_answers.h"
#include "clients/gallery_server/index_columns.h"
#include "clients/gallery_server/questions.h"
#include "clients/gallery_server/refused.h"
#include "clients/gallery_server/series.h"
#include "common/base/error.h"
#include "common/json/value.h"

namespace sleight::gallery {
namespace {

using Json = json::Value;

web::Answer json_answer(const Json& json) {
  return {.content = web::Content(json.dump())};
}

web::Answer packed_answer(std::string bytes) {
  return {.type = "application/octet-stream", .content = web::Content(std::move(bytes))};
}

[[noreturn]] void refuse_unknown() {
  throw Refused(k_not_found, "This address doesn't exist.", "Reload the page.");
}

/// Removes "/word" from the front of a path and returns the word. Returns none if the path doesn't
/// begin with '/'.
std::optional<std::string_view> next_word(std::string_view& path) {
  if (!path.starts_with('/')) return std::nullopt;
  path.remove_prefix(1);
  const std::size_t end = std::min(path.find('/'), path.size());
  const std::string_view word = path.substr(0, end);
  path.remove_prefix(end);
  return word;
}

std::optional<std::size_t> number_of(std::string_view word) {
  std::size_t number = 0;
  const auto [end, failure] = std::from_chars(word.data(), word.data() + word.size(), number);
  if (failure != std::errc() || end != word.data() + word.size()) return std::nullopt;
  return number;
}

std::vector<std::string> split(std::string_view list) {
  std::vector<std::string> names;
  while (!list.empty()) {
    const std::size_t end = std::min(list.find(','), list.size());
    names.emplace_back(list.substr(0, end));
    list.remove_prefix(std::min(end + 1, list.size()));
  }
  return names;
}

}  // namespace

std::string Answers::gallery_text() const {
  Json json{{"version", version_}};
  json.update(gallery_.state());
  const std::string trouble = notes_.trouble();
  json["notes"] = {{"writable", trouble.empty()}, {"words", trouble}};
  return json.dump();
}

web::Answer Answers::operator()(const web::Ask& ask) const {
  try {
    return ask.method == web::Method::post ? post(ask) : get(ask);
  } catch (const Refused& refused) {
    return web::error_answer(refused.status(), refused.what(), refused.what_to_do());
  } catch (const base::Error& error) {
    if (error.exit_code() == base::ExitCode::bad_archive) {
      return web::error_answer(k_damaged, error.what(),
                               "This part of the archive is damaged; other parts may be readable.");
    }
    return web::error_answer(k_bad_request, error.what(), "");
  }
}

web::Answer Answers::get(const web::Ask& ask) const {
  std::string_view path = ask.path;
  if (next_word(path) != "api") refuse_unknown();
  const auto what = next_word(path);
  if (what == "gallery" && path.empty()) return {.content = web::Content(gallery_text())};
  if (what == "notes" && path.empty()) return notes_answer();
  if (what != "archives") refuse_unknown();
  const auto archive = number_of(next_word(path).value_or(""));
  if (!archive || !path.starts_with('/')) refuse_unknown();
  return of_archive(ask, *archive, path.substr(1));
}

web::Answer Answers::of_archive(const web::Ask& ask, std::size_t archive,
                                std::string_view what) const {
  if (archive >= gallery_.archives())
    throw Refused(k_not_found, "This archive doesn't exist.", "Reload the page.");
  // Everything but the index itself is available from an outline.
  const auto snapshot =
      what == "index" ? gallery_.whole_snapshot(archive) : gallery_.snapshot(archive);
  if (!snapshot) refuse_unread(gallery_, archive);
  constexpr std::string_view k_animations = "animations/";
  constexpr std::string_view k_series = "series/";
  if (what == "scene") return json_answer(scene_json(*snapshot));
  if (what == "looks") return packed_answer(looks(*snapshot));
  if (what == "index")
    return packed_answer(
        index_columns(snapshot->index(), snapshot->generation(), snapshot->satisfied_draws()));
  if (what == "table") return packed_answer(table(*snapshot));
  if (what == "animations")
    return packed_answer(several_animations(*snapshot, split(ask.parameter("names").value_or(""))));
  if (what.starts_with(k_animations))
    return packed_answer(one_animation(*snapshot, what.substr(k_animations.size())));
  if (what == "diagnosis")
    return json_answer(diagnosis_json(*snapshot, gallery_.path_of(archive), rules_));
  if (what == "series") return json_answer(series_titles(*snapshot));
  if (what.starts_with(k_series)) {
    return packed_answer(
        series_of(*snapshot, what.substr(k_series.size()), ask.parameter("chain").value_or("0")));
  }
  refuse_unknown();
}

std::vector<std::string> Answers::runs_with_notes() const {
  std::vector<std::string> runs;
  for (std::size_t archive = 0; archive < gallery_.archives(); ++archive) {
    const auto snapshot = gallery_.snapshot(archive);
    if (!snapshot) continue;
    const std::string& run = snapshot->facts().summary.run_id;
    if (!is_run_word(run)) continue;
    notes_.keep_in(run, notes_folder(gallery_.path_of(archive)));
    runs.push_back(run);
  }
  return runs;
}

web::Answer Answers::notes_answer() const {
  Json notes = Json::object();
  for (const std::string& run : runs_with_notes())
    notes[run] = notes_.of_run(run);
  return json_answer({{"notes", std::move(notes)}});
}

web::Answer Answers::post(const web::Ask& ask) const {
  const json::Value question = json::Value::parse_or_null(ask.body);
  if (question.is_null())
    throw Refused(k_bad_request, "The request is not JSON.", "Reload the page.");
  if (ask.path == "/api/find") return json_answer(found(gallery_, question));
  if (ask.path == "/api/groups") return json_answer(grouped(gallery_, question));
  if (ask.path == "/api/alike") return json_answer(alike(gallery_, question));
  if (ask.path != "/api/notes") refuse_unknown();
  const auto text = [&](const char* name) -> std::string {
    const bool is_there = question.is_object() && question.contains(name);
    if (!is_there || !question[name].is_string())
      throw Refused(k_bad_request, fmt::format("The request has no string \"{}\".", name), "");
    return question[name].get<std::string>();
  };
  runs_with_notes();  // sets the folder of each run's notes
  const std::string run = text("run");
  Json notes =
      notes_.change(run, question.contains("notes") ? Json(question["notes"]) : Json(nullptr));
  return json_answer({{"notes", std::move(notes)}, {"words", notes_.trouble()}});
}

}  // namespace sleight::gallery
