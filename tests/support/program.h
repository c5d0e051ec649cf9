// The program as a user starts it: another process, its exit code and what it said.
#pragma once

#include <sys/types.h>

#include <functional>
#include <string>
#include <vector>

#include "support/temp_folder.h"

namespace plumbline::test {

struct Outcome {
  int exit_code = -1;  ///< 1000 + signal if one killed it
  std::string out, err;
};

struct Launch {
  std::function<void()> in_child;  ///< before the program starts: limits
  std::string stdout_path;         ///< a file in place of the captured output
  bool close_stdout_reader = false;
};

/// Runs `plumbline ARGUMENTS…` to its end.
Outcome plumbline(const std::vector<std::string>& arguments, const Launch& launch = {});

/// Same, with stderr on a pseudo-terminal of 100 columns; `err` is what was drawn there.
Outcome plumbline_on_terminal(const std::vector<std::string>& arguments);

/// A run in progress.
class Running {
 public:
  explicit Running(const std::vector<std::string>& arguments, const Launch& launch = {});
  ~Running();
  Running(const Running&) = delete;
  Running& operator=(const Running&) = delete;

  pid_t pid() const { return pid_; }
  Outcome wait();

 private:
  std::string out_path_, err_path_;
  pid_t pid_ = -1;
};

}  // namespace plumbline::test
