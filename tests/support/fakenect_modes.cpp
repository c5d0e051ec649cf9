// fakenect, which comes with libfreenect and plays a folder in a Kinect's place, knows none but raw depth and asserts
// that nothing else is asked for. Preloaded, this tells the modes that a real one has; the images are as they are.
#include <libfreenect.h>

extern "C" {

freenect_frame_mode freenect_find_depth_mode(freenect_resolution resolution, freenect_depth_format format) {
  freenect_frame_mode mode{};
  mode.resolution = resolution;
  mode.depth_format = format;
  mode.bytes = 640 * 480 * 2;
  mode.width = 640;
  mode.height = 480;
  mode.is_valid = 1;
  return mode;
}

int freenect_set_depth_mode(freenect_device* /*device*/, const freenect_frame_mode mode) {
  return mode.depth_format == FREENECT_DEPTH_REGISTERED ? 0 : -1;
}
}
