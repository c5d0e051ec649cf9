// Owners of Embree's handles and the one way a mesh becomes a scene. Header-only, so that `core` itself does not need
// Embree: a folder that includes it links `embree`.
#pragma once

#include <embree3/rtcore.h>

#include <cstring>
#include <memory>
#include <string>
#include <type_traits>

#include "core/error.h"
#include "core/frame.h"

namespace plumbline::embree {

struct Release {
  void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
  void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
  void operator()(RTCGeometry geometry) const { rtcReleaseGeometry(geometry); }
};
using Device = std::unique_ptr<std::remove_pointer_t<RTCDevice>, Release>;
using Scene = std::unique_ptr<std::remove_pointer_t<RTCScene>, Release>;
using Geometry = std::unique_ptr<std::remove_pointer_t<RTCGeometry>, Release>;

/// Throws Error where Embree does not run on this processor.
inline Device make_device() {
  Device device(rtcNewDevice(nullptr));
  if (!device) {
    throw Error("Embree gives no device (code " + std::to_string(rtcGetDeviceError(nullptr)) + ")", "embree",
                "Embree needs an x86-64 processor with SSE2, or NEON");
  }
  return device;
}

/// Throws Error if the last calls on the device failed, above all for want of memory.
inline void check(RTCDevice device, const std::string& where) {
  const RTCError code = rtcGetDeviceError(device);
  if (code == RTC_ERROR_NONE) return;
  throw Error(code == RTC_ERROR_OUT_OF_MEMORY ? "not enough memory for the search tree"
                                              : "Embree failed (code " + std::to_string(code) + ")",
              where, "use a smaller mesh");
}

/// Throws Error if a triangle names a vertex that is not there.
inline void check_indices(const Mesh& mesh, const std::string& where) {
  const std::size_t count = mesh.positions.size();
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Mesh::Triangle& t = mesh.triangles[i];
    if (t.a < count && t.b < count && t.c < count) continue;
    throw Error("triangle " + std::to_string(i) + " names a vertex beyond the last of " + std::to_string(count), where,
                "check the mesh's faces");
  }
}

/// New buffer of a geometry, filled from an array. Embree pads its own buffers as its vector loads need; a shared one
/// would have to be padded by the caller.
template <class T>
void set_buffer(RTCGeometry geometry, RTCBufferType type, RTCFormat format, const T* data, std::size_t count) {
  void* buffer = rtcSetNewGeometryBuffer(geometry, type, 0, format, sizeof(T), count);
  if (buffer != nullptr && count > 0) std::memcpy(buffer, data, sizeof(T) * count);
}

/// A committed scene of one triangle geometry (id 0) whose primitive ids are the triangles' indices. The mesh is
/// copied. Throws Error.
inline Scene make_scene(RTCDevice device, const Mesh& mesh, const std::string& where) {
  check_indices(mesh, where);
  Scene scene(rtcNewScene(device));
  const Geometry geometry(rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE));
  set_buffer(geometry.get(), RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, mesh.positions.data(), mesh.positions.size());
  set_buffer(geometry.get(), RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3, mesh.triangles.data(), mesh.triangles.size());
  check(device, where);
  rtcCommitGeometry(geometry.get());
  rtcAttachGeometryByID(scene.get(), geometry.get(), 0);
  rtcSetSceneFlags(scene.get(), RTC_SCENE_FLAG_ROBUST);
  rtcCommitScene(scene.get());
  check(device, where);
  return scene;
}

}  // namespace plumbline::embree
