// Typed arrays in a device's memory.
#pragma once

#include <cstddef>
#include <iterator>
#include <memory>
#include <vector>

namespace plumbline {

/// Where arrays live: a backend's memory, or the host's.
class DeviceMemory {
 public:
  DeviceMemory() = default;
  DeviceMemory(const DeviceMemory&) = default;
  DeviceMemory& operator=(const DeviceMemory&) = default;
  virtual ~DeviceMemory() = default;

  /// Zeroed bytes, at least 64-byte aligned; freed with the final copy of the pointer. Throws std::bad_alloc. What
  /// calls it is `DeviceArray`.
  virtual std::shared_ptr<void> allocate(std::size_t bytes) const = 0;
  /// Copies to and from that memory.
  virtual void upload(void* device, const void* host, std::size_t bytes) const = 0;
  virtual void download(void* host, const void* device, std::size_t bytes) const = 0;
  virtual void clear(void* device, std::size_t bytes) const = 0;
};

/// The host's own, whose pages cost nothing until they are first written.
class HostMemory final : public DeviceMemory {
 public:
  std::shared_ptr<void> allocate(std::size_t bytes) const override;
  void upload(void* device, const void* host, std::size_t bytes) const override;
  void download(void* host, const void* device, std::size_t bytes) const override;
  void clear(void* device, std::size_t bytes) const override;
};

/// Elements in a device's memory. Copies of the array share them, the final copy frees them. The memory given to a call
/// must be the one that the array was made with.
template <class T>
class DeviceArray {
 public:
  DeviceArray() = default;
  /// Zeros. Throws std::bad_alloc.
  DeviceArray(const DeviceMemory& memory, std::size_t size)
      : size_(size), storage_(size > 0 ? memory.allocate(size * sizeof(T)) : nullptr) {}
  /// A copy of the host's values, which lie one after the other.
  template <class Values>
  requires requires(const Values& values) { std::data(values); }
  DeviceArray(const DeviceMemory& memory, const Values& values) : DeviceArray(memory, std::size(values)) {
    const T* first = std::data(values);
    memory.upload(data(), first, size_ * sizeof(T));
  }

  T* data() const { return static_cast<T*>(storage_.get()); }  ///< in the device's memory; null when empty
  /// The same memory as the parts that every element is made of, one after the other.
  template <class Part>
  Part* parts() const {
    static_assert(sizeof(T) % sizeof(Part) == 0);
    return static_cast<Part*>(storage_.get());
  }
  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }

  void clear(const DeviceMemory& memory) const {
    if (size_ > 0) memory.clear(data(), size_ * sizeof(T));
  }
  std::vector<T> download(const DeviceMemory& memory) const { return download(memory, size_); }
  /// The first `count` elements.
  std::vector<T> download(const DeviceMemory& memory, std::size_t count) const {
    std::vector<T> values(count);
    memory.download(values.data(), data(), count * sizeof(T));
    return values;
  }

 private:
  std::size_t size_ = 0;
  std::shared_ptr<void> storage_;
};

}  // namespace plumbline
