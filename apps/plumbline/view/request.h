// What a page asks of the run, as it comes over the wire.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "view/crop_box.h"

namespace plumbline::app {

/// `shown`: the page has drawn the update of that number. `start` lets a live run that waits begin, `resume` one that
/// stands still go on; `finish` ends the run and has its results written.
enum class RequestKind { shown, start, pause, resume, undo, reset, crop, finish };

struct Request {
  RequestKind kind = RequestKind::shown;
  std::uint64_t number = 0;    ///< of `shown`
  double seconds = 0;          ///< of `undo`
  std::optional<CropBox> box;  ///< of `crop`; none: nothing is cut off
};

constexpr std::size_t kMaxRequestBytes = 2048;

/// Nothing for what is not exactly one of them: another name, a missing or a surplus value, a number that is not finite
/// or out of range.
std::optional<Request> parse_request(std::string_view text);

}  // namespace plumbline::app
