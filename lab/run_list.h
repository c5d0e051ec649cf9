// Independent runs of this program, each with a folder of its own: what is wanted, and what became of it.
#pragma once

#include <string>
#include <vector>

namespace plumbline::app {

struct Run {
  std::string name;                     ///< in tables and messages
  std::string folder;                   ///< of its results; absolute, no other run's
  std::vector<std::string> arguments;   ///< of the program; they decide the result
  std::vector<std::string> incidental;  ///< further ones, which do not: --threads, --quiet
};

enum class RunStatus {
  none,      ///< nothing is there, or a run that was broken off
  finished,  ///< of this program's version and these arguments
  failed,    ///< the program ended with an error
  killed,    ///< the system ended the program
  foreign,   ///< the folder holds a finished run of other arguments or another version, which is left as it is
};

struct RunOutcome {
  RunStatus status = RunStatus::none;
  std::string error;   ///< what was said, where there is something to say
  double seconds = 0;  ///< of wall time, where it ended
};

/// What the folder's record says. A record that cannot be read counts as none.
RunOutcome outcome_of(const Run& run);

/// Creates the folder and removes an old record, so that a run which is broken off leaves none. Throws Error.
void begin_record(const Run& run);

/// Leaves run.json in the folder: arguments, version, how the program ended (`wait_status` as waitpid gives it), and
/// its final words, which are taken from log.txt. Throws Error.
RunOutcome write_record(const Run& run, int wait_status, double seconds);

/// The file in the run's folder that gets what the program prints.
std::string log_path(const Run& run);

/// As JSON and back, for a process that is to carry one of them out. Throws Error for text of another form.
std::string run_list_json(const std::string& program, const std::vector<Run>& runs);
struct RunList {
  std::string program;
  std::vector<Run> runs;
};
RunList parse_run_list(const std::string& json, const std::string& where);

/// Throws Error if two runs have one folder.
void check_folders(const std::vector<Run>& runs);

}  // namespace plumbline::app
