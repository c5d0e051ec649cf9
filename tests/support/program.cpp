#include "support/program.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <pty.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <stdexcept>

namespace plumbline::test {
namespace {

std::vector<char*> argument_pointers(std::vector<std::string>& words) {
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  return pointers;
}

std::vector<std::string> command(const std::vector<std::string>& arguments) {
  std::vector<std::string> words = {PLUMBLINE_PROGRAM};
  words.insert(words.end(), arguments.begin(), arguments.end());
  return words;
}

int exit_code(int status) { return WIFEXITED(status) ? WEXITSTATUS(status) : 1000 + WTERMSIG(status); }

std::string temporary_file() {
  std::string path = testing::TempDir() + "plumbline_output_XXXXXX";
  const int fd = mkstemp(path.data());
  if (fd < 0) throw std::runtime_error("no temporary file at " + path);
  close(fd);
  return path;
}

void redirect(const std::string& path, int to) {
  const int fd = open(path.c_str(), O_WRONLY);
  if (fd < 0) _exit(99);
  dup2(fd, to);
  close(fd);
}

/// A pipe whose reading end is gone, as after `| head -1`.
void break_stdout() {
  int ends[2];
  if (pipe(ends) != 0) _exit(99);
  close(ends[0]);
  dup2(ends[1], STDOUT_FILENO);
  close(ends[1]);
}

}  // namespace

Running::Running(const std::vector<std::string>& arguments, const Launch& launch)
    : out_path_(temporary_file()), err_path_(temporary_file()) {
  std::vector<std::string> words = command(arguments);
  const std::vector<char*> pointers = argument_pointers(words);
  pid_ = fork();
  if (pid_ != 0) return;
  redirect(launch.stdout_path.empty() ? out_path_ : launch.stdout_path, STDOUT_FILENO);
  if (launch.close_stdout_reader) break_stdout();
  redirect(err_path_, STDERR_FILENO);
  if (launch.in_child) launch.in_child();
  execv(pointers[0], pointers.data());
  _exit(98);
}

Running::~Running() {
  if (pid_ > 0) {
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  unlink(out_path_.c_str());
  unlink(err_path_.c_str());
}

Outcome Running::wait() {
  int status = 0;
  waitpid(pid_, &status, 0);
  pid_ = -1;
  return {exit_code(status), read_text(out_path_), read_text(err_path_)};
}

Outcome plumbline(const std::vector<std::string>& arguments, const Launch& launch) {
  return Running(arguments, launch).wait();
}

Outcome plumbline_on_terminal(const std::vector<std::string>& arguments) {
  std::vector<std::string> words = command(arguments);
  const std::vector<char*> pointers = argument_pointers(words);
  const winsize size{24, 100, 0, 0};
  int terminal = -1;
  const pid_t pid = forkpty(&terminal, nullptr, nullptr, &size);
  if (pid == 0) {
    redirect("/dev/null", STDOUT_FILENO);
    execv(pointers[0], pointers.data());
    _exit(98);
  }
  Outcome outcome;
  char buffer[4096];
  for (ssize_t count = 0; (count = read(terminal, buffer, sizeof buffer)) > 0;)
    outcome.err.append(buffer, static_cast<std::size_t>(count));
  close(terminal);
  int status = 0;
  waitpid(pid, &status, 0);
  outcome.exit_code = exit_code(status);
  return outcome;
}

}  // namespace plumbline::test
