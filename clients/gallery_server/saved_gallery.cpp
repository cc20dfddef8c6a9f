#include "clients/gallery_server/saved_gallery.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include <fmt/format.h>

#include "clients/gallery_server/archive_answers.h"
#include "clients/gallery_server/index_columns.h"
#include "clients/gallery_server/saved_folder.h"
#include "clients/gallery_server/series.h"
#include "clients/gallery_server/summary_json.h"
#include "clients/web/gzip.h"
#include "common/base/file_system.h"
#include "common/json/value.h"

namespace sleight::gallery {
namespace {

namespace fs = std::filesystem;
using Json = json::Value;

/// Maximum number of chains whose plots are saved; people cannot distinguish more lines.
constexpr std::uint64_t k_chains_saved_max = 8;

/// A file to write; its content is created when its turn comes.
struct Planned {
  std::string path{};  ///< "0/looks"
  std::size_t archive = 0;
  std::function<std::string()> script{};
};

class Plan {
 public:
  void json(const std::string& path, std::function<Json()> make) {
    files.push_back({path, archive, [path, make = std::move(make)] {
                       return script_of(path, "json", make().dump());
                     }});
  }
  void packed(const std::string& path, std::function<std::string()> make) {
    files.push_back({path, archive, [path, make = std::move(make)] {
                       return script_of(path, "gz", base64(web::gzipped(make())));
                     }});
  }

  std::size_t archive = 0;  ///< the archive of the next files
  std::vector<Planned> files{};
};

std::vector<std::string> names_from(const Snapshot& snapshot, std::size_t first) {
  std::vector<std::string> names;
  const auto& entries = snapshot.index().entries;
  for (std::size_t entry = first; entry < std::min(entries.size(), first + k_animations_at_once);
       ++entry)
    names.push_back(browse::short_text(entries[entry].name));
  return names;
}

void plan_archive(Plan& plan, std::size_t number, const SavedArchive& archive,
                  const analysis::Rules& rules) {
  const Snapshot& snapshot = *archive.snapshot;
  plan.archive = number;
  const auto at = [&](const std::string& name) { return fmt::format("{}/{}", number, name); };
  plan.json(at("scene"), [&snapshot] { return scene_json(snapshot); });
  plan.packed(at("looks"), [&snapshot] { return looks(snapshot); });
  plan.packed(at("table"), [&snapshot] { return table(snapshot); });
  plan.packed(at("index"), [&snapshot] {
    return index_columns(snapshot.index(), snapshot.generation(), snapshot.satisfied_draws());
  });
  const Json titles = series_titles(snapshot);
  plan.json(at("series"), [titles] { return titles; });
  for (const Json& title : titles.elements()) {
    const std::string name = title["name"].get<std::string>();
    if (name == "diagnosis") {
      plan.json(at("diagnosis"), [&snapshot, &archive, &rules] {
        return diagnosis_json(snapshot, archive.name, rules);
      });
      continue;
    }
    const bool is_of_all = title["kind"] == "pair";
    const std::uint64_t chains =
        is_of_all ? 1 : std::min(snapshot.facts().summary.chains, k_chains_saved_max);
    for (std::uint64_t chain = 0; chain < chains; ++chain) {
      plan.packed(at(fmt::format("series-{}-{}", name, chain)), [&snapshot, name, chain] {
        return series_of(snapshot, name, fmt::format("{}", chain));
      });
    }
  }
  for (std::size_t first = 0; first < snapshot.index().entries.size();
       first += k_animations_at_once) {
    plan.packed(at(fmt::format("animations-{}", first / k_animations_at_once)), [&snapshot, first] {
      return several_animations(snapshot, names_from(snapshot, first));
    });
  }
}

Json gallery_json(const std::vector<SavedArchive>& archives, const std::string& version) {
  Json all = Json::array();
  for (std::size_t i = 0; i < archives.size(); ++i) {
    Json json{{"id", i},         {"name", archives[i].name}, {"state", "ready"},
              {"words", ""},     {"reading", nullptr},       {"is_live", false},
              {"live_words", ""}};
    add_facts(json, *archives[i].snapshot);
    all.push_back(std::move(json));
  }
  return {{"version", version},
          {"archives", std::move(all)},
          {"left_out", Json::array()},
          {"notes",
           {{"writable", false},
            {"words", "In a saved gallery, stars and notes last until the page closes."}}}};
}

constexpr std::size_t k_page_bytes_max = 16U << 20U;

std::string script_of(const Planned& file) {
  try {
    return file.script();
  } catch (const base::Error& error) {
    if (error.exit_code() != base::ExitCode::bad_archive) throw;
    throw UnreadableArchive(file.archive, error.what());
  }
}

}  // namespace

std::string base64(std::string_view bytes) {
  constexpr std::string_view k_digits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  constexpr std::size_t k_group = 3;
  constexpr std::uint32_t k_six_bits = 63;
  std::string text;
  text.reserve((bytes.size() + 2) / k_group * 4);
  for (std::size_t first = 0; first < bytes.size(); first += k_group) {
    const std::string_view group = bytes.substr(first, k_group);
    std::uint32_t bits = 0;
    for (std::size_t i = 0; i < k_group; ++i)
      bits = bits << 8U | (i < group.size() ? static_cast<std::uint8_t>(group[i]) : 0U);
    for (std::size_t digit = 0; digit < 4; ++digit) {
      text += digit <= group.size() ? k_digits[bits >> (18U - 6U * digit) & k_six_bits] : '=';
    }
  }
  return text;
}

std::string script_of(const std::string& path, const std::string& kind, const std::string& text) {
  // JSON strings are valid in scripts since ECMAScript 2019. Invalid UTF-8 is replaced.
  return fmt::format("sleightSaved({},{},{});\n", Json(path).dump(), Json(kind).dump(),
                     Json(text).dump());
}

std::uint64_t save_gallery(const std::vector<SavedArchive>& archives, const SaveOptions& options,
                           const analysis::Rules& rules) {
  Plan plan;
  for (std::size_t i = 0; i < archives.size(); ++i)
    plan_archive(plan, i, archives[i], rules);
  try {
    SavedFolder folder(options.folder);
    std::uint64_t bytes = 0;
    for (const char* name : {"index.html", "app.js", "app.css"}) {
      bytes +=
          folder.write(name, base::read_text_file(options.page + "/" + name, k_page_bytes_max));
    }
    for (std::size_t done = 0; done < plan.files.size(); ++done) {
      bytes += folder.write(fmt::format("data/{}.js", plan.files[done].path),
                            script_of(plan.files[done]));
      if (options.progress) options.progress(done + 1, plan.files.size());
    }
    bytes +=
        folder.write("data/gallery.js",
                     script_of("gallery", "json", gallery_json(archives, options.version).dump()));
    bytes += folder.put_in_place();
    return bytes;
  } catch (const fs::filesystem_error& error) {
    throw base::Error(fmt::format("{}: {}", options.folder, error.code().message()));
  }
}

}  // namespace sleight::gallery
