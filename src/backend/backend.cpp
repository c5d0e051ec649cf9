#include "backend/backend.h"

#include "backend/cpu/cpu.h"
#include "backend/cuda/cuda.h"
#include "core/error.h"

namespace plumbline {

Backend::~Backend() = default;

void Backend::upload_rows(void* device, std::size_t device_pitch, const void* host, std::size_t host_pitch,
                          std::size_t row_bytes, int rows) const {
  for (int row = 0; row < rows; ++row) {
    const auto r = static_cast<std::size_t>(row);
    upload(static_cast<char*>(device) + r * device_pitch, static_cast<const char*>(host) + r * host_pitch, row_bytes);
  }
}

Matrix6d IcpSums::hessian() const {
  Matrix6d h;
  int slot = kernels::icp_sum::kHessian;
  for (int i = 0; i < 6; ++i) {
    for (int j = i; j < 6; ++j) h(i, j) = h(j, i) = slots[slot++];
  }
  return h;
}

Vector6d IcpSums::gradient() const { return Eigen::Map<const Vector6d>(slots + kernels::icp_sum::kGradient); }

int IcpSums::median_bin() const {
  std::int64_t total = 0;
  for (const std::int32_t n : histogram) total += n;
  if (total == 0) return -1;
  std::int64_t below = 0;
  for (std::size_t bin = 0; bin < histogram.size(); ++bin) {
    below += histogram[bin];
    if (2 * below >= total) return static_cast<int>(bin);
  }
  return -1;
}

double IcpSums::median_distance() const {
  const int bin = median_bin();
  if (bin < 0) return 0;
  const int last = static_cast<int>(histogram.size()) - 1;
  return bin == last ? last * bin_width : (bin + 0.5) * bin_width;
}

std::unique_ptr<Backend> make_backend(const std::string& name, int threads) {
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
