// Other programs: started, waited for, asked for their output.
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

namespace plumbline::app {

/// The path of the program that runs.
std::string own_program();

/// Starts a program in a process group of its own, so that Ctrl-C reaches it only through us; what it prints goes to
/// the file `log`. It is asked to end (SIGTERM) when our thread is gone. Throws Error if it cannot be started.
pid_t start_program(const std::string& program, const std::vector<std::string>& arguments, const std::string& log);

struct Captured {
  int exit_code = 0;  ///< 127 if there is no such program, 128 + signal if one killed it
  std::string out, err;
};

/// Runs a program of the PATH to its end. Throws Error if no process can be made.
Captured capture(const std::vector<std::string>& words);

}  // namespace plumbline::app
