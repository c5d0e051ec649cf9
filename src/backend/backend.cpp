#include "backend/backend.h"

#include <chrono>

#include "backend/cpu/cpu.h"
#include "backend/cuda/cuda.h"
#include "backend/registration.h"
#include "plumbline/error.h"

namespace plumbline {

Backend::~Backend() = default;

void Backend::upload_rows(void* device, std::size_t device_pitch, const void* host, std::size_t host_pitch,
                          std::size_t row_bytes, int rows) const {
  for (int row = 0; row < rows; ++row) {
    const auto r = static_cast<std::size_t>(row);
    upload(static_cast<char*>(device) + r * device_pitch, static_cast<const char*>(host) + r * host_pitch, row_bytes);
  }
}

kernels::RegistrationState Backend::iterate(const kernels::Registration& registration,
                                            const SE3& model_from_live) const {
  return run_passes(*this, registration, model_from_live);
}

void Backend::wait() const {}
std::size_t Backend::free_memory() const { return 0; }

double Backend::milliseconds(const std::function<void()>& work) const {
  const auto begin = std::chrono::steady_clock::now();
  work();
  wait();
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
}

Matrix6d IcpSums::hessian() const { return kernels::hessian(slots); }

Vector6d IcpSums::gradient() const { return kernels::gradient(slots); }

int IcpSums::median_bin() const { return kernels::median_bin(histogram.data(), static_cast<int>(histogram.size())); }

double IcpSums::median_distance() const {
  return kernels::median_distance(median_bin(), static_cast<int>(histogram.size()) - 1, bin_width);
}

std::shared_ptr<Backend> make_backend(const std::string& name, int threads) {
  if (name == "auto" || name == "cpu") return make_cpu_backend(threads);
  if (name == "cuda" && cuda_info().available) return make_cuda_backend();
  if (name.starts_with("cpu:")) return make_cpu_backend(threads, name.substr(4));
  std::string known;
  for (const BackendInfo& backend : list_backends()) {
    known += (known.empty() ? "" : ", ") + backend.name;
    if (backend.name == name)
      throw Error("this backend is not available: " + backend.description, "--backend " + name, "use --backend auto");
  }
  throw Error("there is no such backend", "--backend " + name, "choose auto or one of: " + known);
}

std::vector<BackendInfo> list_backends() { return {{"cpu", true, cpu_description()}, cuda_info()}; }

}  // namespace plumbline
