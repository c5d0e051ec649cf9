#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "cli/arguments.h"
#include "cli/commands.h"
#include "cli/console.h"
#include "cli/interrupt.h"
#include "io/atomic_file.h"
#include "io/datasets.h"
#include "io/download.h"
#include "plumbline/error.h"

namespace plumbline::app {
namespace {

namespace fs = std::filesystem;

struct DownloadArguments {
  std::string name, folder = ".", mirror, sha256;
  bool list = false, keep = false;
};

/// A line that is drawn over and over on a terminal, and every tenth of the file elsewhere.
class DownloadBar {
 public:
  ~DownloadBar() { erase(); }

  void update(const DownloadProgress& state) {
    if (first_ < 0) first_ = static_cast<double>(state.done);
    const int width = terminal_width();
    const auto now = Clock::now();
    const int tenth = state.total > 0 ? static_cast<int>(10 * state.done / state.total) : 0;
    const bool due = width > 0 ? now - drawn_ > std::chrono::milliseconds(200) : tenth > tenth_;
    if (!due) return;
    drawn_ = now;
    tenth_ = tenth;
    const std::string text = line(state);
    std::fputs(
        width > 0 ? ("\r\x1b[K" + text.substr(0, static_cast<std::size_t>(width - 1))).c_str() : (text + "\n").c_str(),
        stderr);
    std::fflush(stderr);
    visible_ = width > 0;
  }

  void erase() {
    if (visible_) std::fputs("\r\x1b[K", stderr);
    visible_ = false;
  }

 private:
  using Clock = std::chrono::steady_clock;

  std::string line(const DownloadProgress& state) const {
    constexpr double kMega = 1e6;
    constexpr int kColumns = 30;
    const double seconds = std::chrono::duration<double>(Clock::now() - start_).count();
    const double rate = seconds > 0 ? (static_cast<double>(state.done) - first_) / seconds : 0;
    std::string text = fmt::format("{:.0f} MB", static_cast<double>(state.done) / kMega);
    if (state.total > 0) {
      const double share = static_cast<double>(state.done) / static_cast<double>(state.total);
      const auto full = static_cast<std::size_t>(share * kColumns);
      text = fmt::format("{} of {:.0f} MB  [{}{}] {:.0f} %", text, static_cast<double>(state.total) / kMega,
                         std::string(full, '#'), std::string(kColumns - full, '-'), 100 * share);
    }
    text += fmt::format("  {:.1f} MB/s", rate / kMega);
    if (state.total > state.done && rate > 0)
      text += "  ETA " + duration_text(static_cast<double>(state.total - state.done) / rate);
    if (state.broken > 0) text += fmt::format("  (broken off {} time{})", state.broken, state.broken == 1 ? "" : "s");
    return text;
  }

  Clock::time_point start_ = Clock::now(), drawn_{};
  double first_ = -1;
  int tenth_ = 0;
  bool visible_ = false;
};

int list_names() {
  for (const Dataset& dataset : datasets()) say("{:40} {}", dataset.name, dataset.url);
  return 0;
}

/// The same file on another server.
std::string mirrored(const std::string& url, const std::string& mirror) {
  if (mirror.empty()) return url;
  return mirror + (mirror.ends_with('/') ? "" : "/") + url.substr(url.rfind('/') + 1);
}

int stopped(const fs::path& archive, int signal) {
  complain(fmt::format("stopped; what has come lies in {}.partial\n  The same command goes on from there.",
                       archive.string()));
  return 128 + signal;
}

int download(const DownloadArguments& arguments) {
  if (arguments.list) return list_names();
  if (arguments.name.empty())
    throw UsageError("no data set is named", "NAME", "list the names with `plumbline download --list`");
  const Dataset dataset = find_dataset(arguments.name);
  const fs::path target = fs::path(arguments.folder) / dataset.folder;
  if (std::error_code error; fs::exists(target, error)) {
    say("{} is there already; delete it to download it again", target.string());
    return 0;
  }
  ensure_directory(arguments.folder);
  const std::string url = mirrored(dataset.url, arguments.mirror);
  const fs::path archive = fs::path(arguments.folder) / url.substr(url.rfind('/') + 1);
  const std::string& sha256 = arguments.sha256.empty() ? dataset.sha256 : arguments.sha256;

  const InterruptGuard interrupt;
  if (std::error_code error; !fs::exists(archive, error)) {
    say("from {}", url);
    DownloadBar bar;
    DownloadOptions options;
    options.sha256 = sha256;
    options.progress = [&](const DownloadProgress& state) {
      bar.update(state);
      return interrupt.signal() == 0;
    };
    if (download_file(url, archive.string(), options) == DownloadResult::stopped) {
      bar.erase();
      return stopped(archive, interrupt.signal());
    }
  }
  say("sha256 {}  {}", sha256_of(archive.string()), archive.filename().string());
  unpack_archive(archive.string(), target.string(), [&] { return interrupt.signal() == 0; });
  if (!arguments.keep) fs::remove(archive);
  say("{} is there: plumbline run {} -o out", dataset.name, target.string());
  return 0;
}

}  // namespace

void add_download_command(CLI::App& app, Command& chosen) {
  const auto arguments = std::make_shared<DownloadArguments>();
  DownloadArguments& a = *arguments;
  CLI::App* command = app.add_subcommand("download", "Fetch a public data set by its short name");
  command->add_option("name", a.name, "Such as fr1/xyz or icl/office_kt3")->type_name("NAME");
  command->add_option("-o,--output", a.folder, "Folder to put it into (default: here)")->type_name("DIR");
  command->add_flag("--list", a.list, "List the names and where they come from");
  command->add_flag("--keep", a.keep, "Keep the archive after unpacking");
  command->add_option("--mirror", a.mirror, "Folder on another server that has the archives")->type_name("URL");
  command->add_option("--sha256", a.sha256, "Checksum that the archive must have")->type_name("HEX");
  command->footer("A download that broke off, or was stopped with Ctrl-C, goes on where it was.");
  command->callback([arguments, &chosen] { chosen = [arguments] { return download(*arguments); }; });
}

}  // namespace plumbline::app
