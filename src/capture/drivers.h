// The depth devices that there are; each in a file of its own, and those with a library only where it was found.
#pragma once

#include <memory>
#include <string>

#include "capture/depth_device.h"

namespace plumbline::capture {

/// Plays a folder that open_sequence() reads, as if a camera took it now. With a speed of 1 frames come when their
/// stamps say, and those that nobody fetched in time are missed, as with a camera; with 0 each waits to be fetched.
/// Stamps keep the sequence's distances whatever the speed.
std::unique_ptr<DepthDevice> make_virtual_device(const std::string& folder, const DepthDeviceOptions& options);

/// `uri`: empty for any camera, a file (.oni), or a URI of OpenNI.
std::unique_ptr<DepthDevice> make_openni2_device(const std::string& uri, const DepthDeviceOptions& options);

/// `index`: of the Kinect, counted from 0; empty for the first.
std::unique_ptr<DepthDevice> make_freenect_device(const std::string& index, const DepthDeviceOptions& options);

/// What the user said of the camera.
void apply(const DepthDeviceOptions& options, DepthDeviceInfo* info);

}  // namespace plumbline::capture
