#include "lab/run_list.h"

#include <fmt/format.h>
#include <sys/wait.h>

#include <csignal>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>

#include "cli/arguments.h"
#include "io/atomic_file.h"
#include "io/text_file.h"
#include "plumbline/error.h"

namespace plumbline::app {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

std::string record_path(const Run& run) { return (fs::path(run.folder) / "run.json").string(); }

/// The end of what a program said: its error, with the advice that follows, or else the final line.
std::string final_words(const std::string& log) {
  constexpr std::string_view kMark = "plumbline: error: ";
  std::string_view text = log;
  while (!text.empty() && text.back() == '\n') text.remove_suffix(1);
  if (const std::size_t error = text.rfind(kMark); error != std::string_view::npos)
    return std::string(text.substr(error + kMark.size()));
  const std::size_t line = text.rfind('\n');
  return std::string(line == std::string_view::npos ? text : text.substr(line + 1));
}

std::string words_in_log(const Run& run) {
  try {
    return final_words(read_file(log_path(run)));
  } catch (const Error&) {
    return {};
  }
}

RunOutcome judge(const Run& run, int wait_status, double seconds) {
  if (WIFEXITED(wait_status) && WEXITSTATUS(wait_status) == 0) return {RunStatus::finished, {}, seconds};
  const std::string words = words_in_log(run);
  if (WIFEXITED(wait_status))
    return {RunStatus::failed, words.empty() ? fmt::format("exit code {}", WEXITSTATUS(wait_status)) : words, seconds};
  const int signal = WTERMSIG(wait_status);
  return {RunStatus::killed,
          fmt::format("killed by signal {} ({}){}{}", signal, strsignal(signal),
                      signal == SIGKILL ? ", perhaps for want of memory" : "", words.empty() ? "" : "\n  " + words),
          seconds};
}

constexpr std::pair<RunStatus, const char*> kRecorded[] = {
    {RunStatus::finished, "finished"}, {RunStatus::failed, "failed"}, {RunStatus::killed, "killed"}};

std::string dump(const Json& json) {
  // Paths may hold bytes that are not UTF-8, which JSON cannot.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace

std::string log_path(const Run& run) { return (fs::path(run.folder) / "log.txt").string(); }

RunOutcome outcome_of(const Run& run) {
  RunOutcome outcome;
  try {
    const Json record = Json::parse(read_file(record_path(run)));
    for (const auto& [status, name] : kRecorded)
      if (record.at("status") == name) outcome.status = status;
    outcome.seconds = record.at("seconds");
    outcome.error = record.at("error");
    const bool same =
        record.at("plumbline") == PLUMBLINE_VERSION && record.at("arguments") == Json::parse(dump(run.arguments));
    if (same) return outcome;
    if (outcome.status != RunStatus::finished) return {};
    return {RunStatus::foreign,
            fmt::format("{}: the folder holds a run of another command or version: {}\n  Remove it, or give another "
                        "folder with -o.",
                        run.folder, command_text(record.at("arguments").get<std::vector<std::string>>())),
            outcome.seconds};
  } catch (const Error&) {
  } catch (const Json::exception&) {
  }
  return {};
}

void begin_record(const Run& run) {
  ensure_directory(run.folder);
  std::error_code error;
  fs::remove(record_path(run), error);
  if (error)
    throw Error("the record of an older run cannot be removed (" + error.message() + ")", record_path(run), "");
}

RunOutcome write_record(const Run& run, int wait_status, double seconds) {
  const RunOutcome outcome = judge(run, wait_status, seconds);
  Json record = {{"plumbline", PLUMBLINE_VERSION}, {"arguments", run.arguments}};
  for (const auto& [status, name] : kRecorded)
    if (outcome.status == status) record["status"] = name;
  record["seconds"] = seconds;
  record["error"] = outcome.error;
  write_file(record_path(run), dump(record));
  return outcome;
}

std::string run_list_json(const std::string& program, const std::vector<Run>& runs) {
  Json json = {{"program", program}, {"runs", Json::array()}};
  for (const Run& run : runs)
    json["runs"].push_back(
        {{"name", run.name}, {"folder", run.folder}, {"arguments", run.arguments}, {"incidental", run.incidental}});
  try {
    return json.dump(2) + "\n";
  } catch (const Json::exception&) {
    throw Error("a path is not UTF-8", "list of runs", "Rename the folder, or use --executor local.");
  }
}

RunList parse_run_list(const std::string& json, const std::string& where) {
  try {
    const Json list = Json::parse(json);
    RunList result;
    result.program = list.at("program");
    for (const Json& run : list.at("runs"))
      result.runs.push_back({run.at("name"), run.at("folder"), run.at("arguments"), run.at("incidental")});
    return result;
  } catch (const Json::exception& error) {
    throw Error(fmt::format("this is no list of runs ({})", error.what()), where, "");
  }
}

void check_folders(const std::vector<Run>& runs) {
  std::set<std::string> folders;
  for (const Run& run : runs)
    if (!folders.insert(run.folder).second)
      throw Error("two runs would write into one folder", run.folder, "Give each value once.");
}

}  // namespace plumbline::app
