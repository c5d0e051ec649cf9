#include "lab/child_process.h"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>

#include "io/atomic_file.h"
#include "plumbline/error.h"

namespace plumbline::app {
namespace {

constexpr int kNoSuchProgram = 127;  // as shells have it

std::vector<char*> pointers_to(std::vector<std::string>& words) {
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  return pointers;
}

[[noreturn]] void throw_no_process(const std::string& program) {
  throw Error(std::string("no process can be started (") + std::strerror(errno) + ")", program,
              "End other programs, or give fewer --jobs.");
}

/// Of the child, between fork and exec: nothing here may allocate.
void redirect(int input, int output, int errors) {
  dup2(input, STDIN_FILENO);
  dup2(output, STDOUT_FILENO);
  dup2(errors, STDERR_FILENO);
  std::signal(SIGPIPE, SIG_DFL);
  std::signal(SIGXFSZ, SIG_DFL);
}

class Descriptor {
 public:
  Descriptor(const std::string& path, int flags) : fd_(open(path.c_str(), flags | O_CLOEXEC, 0666)) {
    if (fd_ < 0) throw_write_error(path, errno);
  }
  ~Descriptor() { close(fd_); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return fd_; }

 private:
  int fd_;
};

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, CloseFile>;

std::string content(std::FILE* file) {
  std::string text;
  std::rewind(file);
  char buffer[4096];
  for (std::size_t n = 0; (n = std::fread(buffer, 1, sizeof buffer, file)) > 0;) text.append(buffer, n);
  return text;
}

}  // namespace

std::string own_program() { return std::filesystem::read_symlink("/proc/self/exe").string(); }

pid_t start_program(const std::string& program, const std::vector<std::string>& arguments, const std::string& log) {
  std::vector<std::string> words = {program};
  words.insert(words.end(), arguments.begin(), arguments.end());
  const std::vector<char*> pointers = pointers_to(words);
  const Descriptor input("/dev/null", O_RDONLY), output(log, O_WRONLY | O_CREAT | O_TRUNC | O_APPEND);
  const pid_t parent = getpid(), pid = fork();
  if (pid < 0) throw_no_process(program);
  if (pid > 0) {
    setpgid(pid, pid);  // in both, whichever comes first
    return pid;
  }
  setpgid(0, 0);
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (getppid() != parent) _exit(kNoSuchProgram);
  redirect(input.get(), output.get(), output.get());
  execv(pointers[0], pointers.data());
  constexpr char kMessage[] = "plumbline: error: the program cannot be started\n";
  [[maybe_unused]] const ssize_t ignored = write(STDERR_FILENO, kMessage, sizeof kMessage - 1);
  _exit(kNoSuchProgram);
}

namespace {

/// The exit code as a shell gives it.
int wait_for(pid_t pid) {
  int status = 0;
  while (waitpid(pid, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

}  // namespace

Captured capture(const std::vector<std::string>& words) {
  std::vector<std::string> copy = words;
  const std::vector<char*> pointers = pointers_to(copy);
  const Descriptor input("/dev/null", O_RDONLY);
  const File out(std::tmpfile()), err(std::tmpfile());
  if (!out || !err) throw_no_process(words.front());
  const int out_fd = fileno(out.get()), err_fd = fileno(err.get());
  const pid_t pid = fork();
  if (pid < 0) throw_no_process(words.front());
  if (pid == 0) {
    redirect(input.get(), out_fd, err_fd);
    execvp(pointers[0], pointers.data());
    _exit(kNoSuchProgram);
  }
  const int exit_code = wait_for(pid);
  return {exit_code, content(out.get()), content(err.get())};
}

}  // namespace plumbline::app
