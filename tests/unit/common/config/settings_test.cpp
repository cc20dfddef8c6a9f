// Goal: each setting comes from the first source that sets it, and records that source. Each error
// names its place and the expected value. Method: use made-up environments and files. One test
// reads a real environment and a real file.
#include "common/config/settings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>

#include "common/base/error.h"
#include "tests/support/facts.h"

namespace sleight::config {
namespace {

using Variables = std::map<std::string, std::string, std::less<>>;

Surroundings surroundings(Variables variables) {
  return {.variable = [variables = std::move(variables)](
                          std::string_view name) -> std::optional<std::string> {
            const auto at = variables.find(name);
            return at == variables.end() ? std::nullopt : std::optional(at->second);
          },
          .cores = 12,
          .memory_bytes = 64'000'000'000};
}

const Variables k_ada{{"HOME", "/people/ada"}};

Settings good(const Variables& variables, const std::string& file = "",
              const std::vector<Given>& command_line = {}) {
  const auto settings =
      settings_of(surroundings(variables), ConfigFile{"/c/config.toml", file}, command_line);
  if (settings) return settings.value();
  for (const auto& error : settings.error())
    ADD_FAILURE() << request::to_string(error);
  return {};
}

std::string errors(const Variables& variables, const std::string& file,
                   const std::vector<Given>& command_line = {}) {
  const auto settings =
      settings_of(surroundings(variables), ConfigFile{"config.toml", file}, command_line);
  std::string lines;
  if (!settings) {
    for (const auto& error : settings.error())
      lines += request::to_string(error) + '\n';
  }
  return lines;
}

TEST(Settings, NothingNeedsConfiguring) {
  const auto settings = settings_of(surroundings(k_ada), std::nullopt);
  ASSERT_TRUE(settings.ok());
  const Settings& s = settings.value();
  EXPECT_EQ(s.state.value, "/people/ada/.local/state/sleight");
  EXPECT_EQ(s.socket.value, "/people/ada/.local/state/sleight/socket");
  EXPECT_EQ(s.cores.value, 12U);
  EXPECT_EQ(s.memory_bytes.value, 48'000'000'000U);
  EXPECT_EQ(s.limits.jobs.value, k_jobs_of_user);
  EXPECT_EQ(s.limits.bytes.value, std::nullopt);
  for (const Row& row : rows_of(s)) {
    EXPECT_EQ(row.origin, Origin::fallback) << row.key;
    EXPECT_EQ(row.given_by, "") << row.key;
  }
}

TEST(Settings, FoldersFollowTheXdgVariables) {
  const Variables xdg{
      {"HOME", "/people/ada"}, {"XDG_STATE_HOME", "/var/ada"}, {"XDG_CONFIG_HOME", "/etc/ada"}};
  EXPECT_EQ(good(xdg).state.value, "/var/ada/sleight");
  EXPECT_EQ(config_path_of(surroundings(xdg)), "/etc/ada/sleight/config.toml");
  EXPECT_EQ(config_path_of(surroundings(k_ada)), "/people/ada/.config/sleight/config.toml");
  // A relative path in XDG_STATE_HOME is ignored.
  const Variables relative{{"HOME", "/people/ada"}, {"XDG_STATE_HOME", "ada"}};
  EXPECT_EQ(good(relative).state.value, "/people/ada/.local/state/sleight");
  EXPECT_EQ(config_path_of(surroundings({})), std::nullopt);
}

TEST(Settings, FileIsRead) {
  const Settings s = good(k_ada,
                          "state = \"~/s\"\ncores = 8\nmemory = \"24 GB\"\ndisk_reserve = 5\n"
                          "slice = \"5m\"\nkeep_days = 7\nkeep_bytes = \"1 TB\"\ncache_mb = 64\n"
                          "[limits]\njobs = 3\ncores = 4\ncore_hours = 100\nbytes = \"2 GB\"\n");
  EXPECT_EQ(s.state.value, "/people/ada/s");
  EXPECT_EQ(s.socket.value, "/people/ada/s/socket");
  EXPECT_EQ(s.cores.value, 8U);
  EXPECT_EQ(s.memory_bytes.value, 24'000'000'000U);
  EXPECT_EQ(s.disk_reserve_bytes.value, 5U);
  EXPECT_EQ(s.slice_s.value, 300.0);
  EXPECT_EQ(s.keep_days.value, 7U);
  EXPECT_EQ(s.keep_bytes.value, 1'000'000'000'000U);
  EXPECT_EQ(s.cache_mb.value, 64U);
  EXPECT_EQ(s.limits.jobs.value, 3U);
  EXPECT_EQ(s.limits.cores.value, 4U);
  EXPECT_EQ(s.limits.core_hours.value, 100U);
  EXPECT_EQ(s.limits.bytes.value, 2'000'000'000U);
  EXPECT_EQ(s.limits.jobs.origin, Origin::file);
  EXPECT_EQ(s.limits.jobs.given_by, "/c/config.toml:10:1");
}

TEST(Settings, FirstSourceWins) {
  const std::string file = "state = \"/file\"\nsocket = \"/file/s\"\ncores = 2\n";
  const Variables both{
      {"HOME", "/people/ada"}, {"SLEIGHT_STATE", "/environment"}, {"SLEIGHT_SOCKET", ""}};
  const Settings s = good(both, file, {{"cores", "3", "--cores"}, {"slice", "20s", "--slice"}});
  EXPECT_EQ(s.state, (Setting<std::string>{"/environment", Origin::environment, "SLEIGHT_STATE"}));
  EXPECT_EQ(s.socket, (Setting<std::string>{"/file/s", Origin::file, "/c/config.toml:2:1"}));
  EXPECT_EQ(s.cores, (Setting<std::uint64_t>{3, Origin::command_line, "--cores"}));
  EXPECT_EQ(s.slice_s.value, 20);
  EXPECT_EQ(good(both, file, {{"state", "/line", "--state"}}).state.value, "/line");
}

TEST(Settings, ErrorsOfTheFileHaveTheirPlaces) {
  EXPECT_THAT(errors(k_ada, "cors = 4\n"),
              tests::LinesHaveFacts("config.toml:1:1: |'cors'|'cores'"));
  EXPECT_THAT(errors(k_ada, "jobs = 4\n"),
              tests::LinesHaveFacts("config.toml:1:1: |'jobs'|[limits]"));
  EXPECT_THAT(errors(k_ada, "[limits]\nslice = 4\n"),
              tests::LinesHaveFacts("config.toml:2:1: |'slice' in [limits]|before"));
  EXPECT_THAT(errors(k_ada, "[limits]\njob = 4\n"),
              tests::LinesHaveFacts("config.toml:2:1: |'job' in [limits]|'jobs' in [limits]"));
  EXPECT_THAT(errors(k_ada, "limits = 4\n"),
              tests::LinesHaveFacts("config.toml:1:1: |'limits'|section|[limits]"));
  EXPECT_THAT(errors(k_ada, "[daemon]\ncores = 4\n"),
              tests::LinesHaveFacts("config.toml:1:2: |[daemon]|[limits]|[slurm]|before"));
  EXPECT_THAT(errors(k_ada, "cores = 0\nmemory = \"much\"\nslice = 0\nstate = \"here\"\n"),
              tests::LinesHaveFacts("config.toml:1:9: 'cores': |1|65536|0\n"
                                    "config.toml:2:10: 'memory': |1 byte|9 PB|\"24 GB\"|\"much\"\n"
                                    "config.toml:3:9: 'slice': |\"10s\"|0\n"
                                    "config.toml:4:9: 'state': |absolute|\"here\""));
  EXPECT_THAT(errors(k_ada, "[limits]\njobs = -1\n"),
              tests::HasFacts("config.toml:2:8: 'jobs' in [limits]: |1"));
  EXPECT_THAT(errors(k_ada, "cores = \n"), testing::HasSubstr("config.toml:1:9: not valid TOML"));
}

TEST(Settings, AGroupNeedsASocketOutsideOfTheStateFolder) {
  // Only the owner can open the state folder, so a group can't reach a socket inside that folder.
  EXPECT_EQ(errors(k_ada, "socket = \"/run/sleight/socket\"\ngroup = \"film\"\n"), "");
  EXPECT_THAT(errors(k_ada, "group = \"film\"\n"),
              tests::LinesHaveFacts("config.toml:1:1: |group|state folder|socket"));
  EXPECT_THAT(
      errors(k_ada, "state = \"/s\"\nsocket = \"/s/socket\"\n", {{"group", "film", "--group"}}),
      tests::LinesHaveFacts("--group: |state folder|socket"));
  EXPECT_THAT(errors(k_ada, "group = 4\nallow_root = \"yes\"\n"),
              tests::LinesHaveFacts("config.toml:1:9: 'group': |string|4\n"
                                    "config.toml:2:14: 'allow_root': |true|false|\"yes\""));
}

TEST(Settings, AddressesAreReadWithTheirPort) {
  Variables variables = k_ada;
  variables["SLEIGHT_SERVER"] = "render.example.org";
  const Settings s = good(variables, "listen = '0.0.0.0:9000'\nserver = 'other:1'\n");
  EXPECT_EQ(s.server.value, "render.example.org:7423");
  EXPECT_EQ(s.server.given_by, "SLEIGHT_SERVER");
  EXPECT_EQ(s.listen.value, "0.0.0.0:9000");
  EXPECT_THAT(errors(k_ada, "listen = 'a b'\n"),
              testing::HasSubstr("config.toml:1:10: 'listen': expected an address"));
  EXPECT_THAT(errors(k_ada, "server = 7\n"), testing::HasSubstr("'server': expected an address"));
}

TEST(Settings, ACertificateAndItsKeyComeTogether) {
  EXPECT_EQ(good(k_ada, "tls_certificate = '/c.pem'\ntls_key = '/k.pem'\n").tls_key.value,
            "/k.pem");
  EXPECT_THAT(errors(k_ada, "tls_certificate = '/c.pem'\n"),
              testing::HasSubstr("requires tls_key"));
  EXPECT_THAT(errors(k_ada, "tls_key = '/k.pem'\n"),
              testing::HasSubstr("requires tls_certificate"));
}

TEST(Settings, ABatchSystemHasOtherDefaults) {
  const Settings here = good(k_ada);
  EXPECT_EQ(here.backend.value, "local");
  EXPECT_EQ(here.job_cores.value, 0U);
  const Settings slurm = good(k_ada, "backend = 'slurm'\n[slurm]\npartition = 'long'\n");
  EXPECT_EQ(slurm.cores.value, k_system_cores);
  EXPECT_EQ(slurm.memory_bytes.value, k_system_memory_bytes);
  EXPECT_EQ(slurm.job_cores.value, k_system_job_cores);
  EXPECT_EQ(slurm.slurm.partition.value, "long");
  EXPECT_EQ(good(k_ada, "backend = 'slurm'\ncores = 3\n").cores.value, 3U);
  EXPECT_THAT(errors(k_ada, "backend = 'pbs'\n"),
              tests::HasFacts("\"local\"|\"slurm\"|absolute path|\"pbs\""));
}

TEST(Settings, FlagsAreSwitchedOnAnywhere) {
  const auto is_allowed = [](const Variables& variables, const std::string& file,
                             const std::vector<Given>& command_line = {}) {
    return good(variables, file, command_line).allow_root.value;
  };
  EXPECT_FALSE(is_allowed(k_ada, ""));
  EXPECT_TRUE(is_allowed(k_ada, "allow_root = true\n"));
  EXPECT_TRUE(is_allowed({{"HOME", "/h"}, {"SLEIGHT_ALLOW_ROOT", "1"}}, ""));
  EXPECT_FALSE(is_allowed({{"HOME", "/h"}, {"SLEIGHT_ALLOW_ROOT", "0"}}, "allow_root = true\n"));
  EXPECT_TRUE(is_allowed(k_ada, "allow_root = false\n", {{"allow_root", "true", "--allow-root"}}));
  EXPECT_THAT(errors({{"HOME", "/h"}, {"SLEIGHT_ALLOW_ROOT", "yes"}}, ""),
              tests::LinesHaveFacts("SLEIGHT_ALLOW_ROOT: |true|false|\"yes\""));
}

TEST(Settings, ErrorsElsewhereNameWhatGaveThem) {
  EXPECT_THAT(errors({{"HOME", "/people/ada"}, {"SLEIGHT_STATE", "here"}}, ""),
              tests::LinesHaveFacts("SLEIGHT_STATE: |absolute path|\"here\""));
  EXPECT_THAT(errors(k_ada, "", {{"cores", "many", "--cores"}}),
              tests::LinesHaveFacts("--cores: |1|65536|\"many\""));
  EXPECT_THAT(errors({}, ""), testing::HasSubstr("HOME: expected an absolute path"));
  EXPECT_EQ(errors({{"SLEIGHT_STATE", "/s"}}, ""), "");
  const std::string deep = "/" + std::string(120, 'd');
  EXPECT_THAT(errors({{"SLEIGHT_STATE", deep}}, ""),
              testing::AllOf(testing::StartsWith("SLEIGHT_STATE: the socket path /dddd"),
                             tests::HasFacts("128 bytes|107|SLEIGHT_SOCKET")));
  EXPECT_EQ(errors({{"SLEIGHT_STATE", deep}, {"SLEIGHT_SOCKET", "/run/s"}}, ""), "");
}

TEST(Settings, RowsTellEverySettingAsTheFileWouldHaveIt) {
  // Goal: rows_of() lists every setting, in the form of the configuration file. Method: set every
  // value, write the rows as a file, and read the file again.
  const Settings s =
      good(k_ada,
           "state = \"/a\"\nsocket = \"/b\"\ngroup = \"film\"\nlisten = \"[::1]:2\"\n"
           "tls_certificate = \"/c\"\ntls_key = \"/k\"\nbackend = \"slurm\"\nallow_root = true\n"
           "cores = 8\njob_cores = 3\nmemory = \"24 GB\"\n"
           "disk_reserve = \"5 MB\"\nslice = \"5m\"\nkeep_days = 7\nkeep_bytes = \"1 TB\"\n"
           "cache_mb = 64\nserver = \"a.b:1\"\n"
           "[limits]\njobs = 3\ncores = 4\ncore_hours = 100\nbytes = \"2 GB\"\nstates = 5\n"
           "simulations = 6\n"
           "[slurm]\naccount = \"a\"\npartition = \"p\"\nqos = \"q\"\ntime = \"1:00\"\n"
           "more = \"--exclusive\"\nscript = \"/s\"\n");
  std::string file;
  std::map<std::string, std::string> sections;
  for (const Row& row : rows_of(s)) {
    EXPECT_EQ(row.origin, Origin::file) << row.key;
    EXPECT_FALSE(row.help.empty()) << row.key;
    EXPECT_EQ(row.is_text || row.is_flag, !row.number.has_value()) << row.key;
    const bool is_quoted = row.is_text || row.unit == "bytes" || row.unit == "s";
    const std::string line = " = " + (is_quoted ? "\"" + row.value + "\"" : row.value) + "\n";
    const std::size_t dot = row.key.find('.');
    if (dot == std::string::npos) {
      file += row.key + line;
    } else {
      sections[row.key.substr(0, dot)] += row.key.substr(dot + 1) + line;
    }
  }
  for (const auto& [name, lines] : sections)
    file += "[" + name + "]\n" + lines;
  const Settings again = good(k_ada, file);
  EXPECT_EQ(again, s);
}

TEST(Settings, ShellReadsEnvironmentAndFile) {
  const std::filesystem::path folder =
      std::filesystem::path(testing::TempDir()) / "sleight_settings_test";
  std::filesystem::create_directories(folder / "sleight");
  ::setenv("XDG_CONFIG_HOME", folder.c_str(), 1);
  ::setenv("SLEIGHT_STATE", "/from/environment", 1);
  std::ofstream(folder / "sleight/config.toml") << "keep_days = 3\n";
  const Settings s = settings_here({{"cores", "1", "--cores"}});
  EXPECT_EQ(s.state.value, "/from/environment");
  EXPECT_EQ(s.keep_days.value, 3U);
  EXPECT_EQ(s.cores.value, 1U);
  EXPECT_GE(surroundings_here().memory_bytes, std::uint64_t{1} << 24U);

  std::ofstream(folder / "sleight/config.toml") << "keep_day = 3\n";
  try {
    settings_here();
    ADD_FAILURE() << "an unknown key was taken";
  } catch (const base::Error& error) {
    EXPECT_EQ(error.exit_code(), base::ExitCode::usage);
    EXPECT_THAT(error.what(), testing::HasSubstr("config.toml:1:1: unknown key 'keep_day'"));
  }
  std::filesystem::remove_all(folder);
  EXPECT_EQ(settings_here().keep_days.origin, Origin::fallback);
}

}  // namespace
}  // namespace sleight::config
