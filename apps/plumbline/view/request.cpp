#include "view/request.h"

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

namespace plumbline::app {
namespace {

using RequestJson = nlohmann::json;

constexpr double kMaxCoordinate = 1e5;  ///< metres
constexpr double kMaxUndo = 3600;       ///< seconds

template <std::size_t N>
std::optional<std::array<double, N>> numbers(const RequestJson& object, const char* name, double limit) {
  const auto found = object.find(name);
  if (found == object.end() || !found->is_array() || found->size() != N) return std::nullopt;
  std::array<double, N> values{};
  for (std::size_t i = 0; i < N; ++i) {
    const RequestJson& value = (*found)[i];
    if (!value.is_number()) return std::nullopt;
    values[i] = value.get<double>();
    if (!(std::abs(values[i]) <= limit)) return std::nullopt;  // nor NaN
  }
  return values;
}

std::optional<CropBox> box_of(const RequestJson& object) {
  if (!object.is_object() || object.size() != 3) return std::nullopt;
  const auto middle = numbers<3>(object, "middle", kMaxCoordinate), size = numbers<3>(object, "size", kMaxCoordinate);
  const auto turn = numbers<4>(object, "turn", 2);  // quaternion x y z w
  if (!middle || !size || !turn) return std::nullopt;
  const Eigen::Quaterniond q((*turn)[3], (*turn)[0], (*turn)[1], (*turn)[2]);
  const Eigen::Vector3d half = 0.5 * Eigen::Vector3d((*size)[0], (*size)[1], (*size)[2]);
  if (!(half.minCoeff() > 0) || std::abs(q.norm() - 1) > 1e-3) return std::nullopt;
  return CropBox{SE3(q.normalized(), {(*middle)[0], (*middle)[1], (*middle)[2]}), half};
}

std::optional<Request> with_number(const RequestJson& object) {
  const auto number = object.find("number");
  if (object.size() != 2 || number == object.end() || !number->is_number_unsigned()) return std::nullopt;
  return Request{RequestKind::shown, number->get<std::uint64_t>(), 0, {}};
}

std::optional<Request> with_seconds(const RequestJson& object) {
  const auto seconds = object.find("seconds");
  if (object.size() != 2 || seconds == object.end() || !seconds->is_number()) return std::nullopt;
  const auto value = seconds->get<double>();
  if (!(value > 0 && value <= kMaxUndo)) return std::nullopt;
  return Request{RequestKind::undo, 0, value, {}};
}

std::optional<Request> with_box(const RequestJson& object) {
  Request request{RequestKind::crop, 0, 0, {}};
  if (object.size() == 1) return request;
  const auto box = object.find("box");
  if (object.size() != 2 || box == object.end()) return std::nullopt;
  request.box = box_of(*box);
  if (!request.box) return std::nullopt;
  return request;
}

}  // namespace

std::optional<Request> parse_request(std::string_view text) {
  if (text.size() > kMaxRequestBytes) return std::nullopt;
  const RequestJson object = RequestJson::parse(text, nullptr, false);
  if (!object.is_object()) return std::nullopt;
  const auto found = object.find("do");
  if (found == object.end() || !found->is_string()) return std::nullopt;
  const auto& name = found->get_ref<const std::string&>();
  if (name == "shown") return with_number(object);
  if (name == "undo") return with_seconds(object);
  if (name == "crop") return with_box(object);
  if (object.size() != 1) return std::nullopt;
  if (name == "start") return Request{RequestKind::start, 0, 0, {}};
  if (name == "pause") return Request{RequestKind::pause, 0, 0, {}};
  if (name == "resume") return Request{RequestKind::resume, 0, 0, {}};
  if (name == "reset") return Request{RequestKind::reset, 0, 0, {}};
  if (name == "finish") return Request{RequestKind::finish, 0, 0, {}};
  return std::nullopt;
}

}  // namespace plumbline::app
