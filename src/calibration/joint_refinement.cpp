#include "calibration/joint_refinement.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "calibration/hand_eye.h"
#include "plumbline/angles.h"
#include "plumbline/orientation.h"
#include "plumbline/se3.h"
#include "plumbline/time.h"
#include "plumbline/trajectory.h"
#include "sensor/periodic_error.h"

namespace plumbline {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;

constexpr int kHarmonics = 4;  // one more than the simulated chip has
constexpr int kTiltCoefficients = 2 * 2 * kHarmonics, kHeadingCoefficients = 2 * kHarmonics;
constexpr double kKnotInterval = 0.5;  // seconds; more where there would be too many knots
constexpr int kMaxKnots = 200;
constexpr int kScaleRounds = 8;       // of noise and prior scales
constexpr double kHuberSigmas = 3.5;  // standard deviations

double plain(double value) { return value; }
template <class T, int N>
double plain(const ceres::Jet<T, N>& value) {
  return value.a;
}

template <class T>
Eigen::Quaternion<T> exp_of(const Eigen::Matrix<T, 3, 1>& rotation) {
  T q[4];  // w x y z
  ceres::AngleAxisToQuaternion(rotation.data(), q);
  return {q[0], q[1], q[2], q[3]};
}

template <class T>
Eigen::Matrix<T, 3, 1> log_of(const Eigen::Quaternion<T>& rotation) {
  const T q[4] = {rotation.w(), rotation.x(), rotation.y(), rotation.z()};
  Eigen::Matrix<T, 3, 1> out;
  ceres::QuaternionToAngleAxis(q, out.data());
  return out;
}

/// The sensor's orientation over its own time, in seconds after an origin; differentiable in that time.
class SensorCurve {
 public:
  SensorCurve(const std::vector<OrientationSample>& samples, Nanoseconds origin) {
    for (std::size_t i = 0; i < samples.size(); ++i) {
      times_.push_back(to_seconds(samples[i].time - origin));
      rotations_.emplace_back(samples[i].earth_from_body);
      if (i > 0) steps_.push_back(so3::log(samples[i - 1].earth_from_body.transpose() * samples[i].earth_from_body));
    }
  }

  /// At constant rate between two samples and beyond the last ones.
  template <class T>
  Eigen::Quaternion<T> at(const T& seconds) const {
    const auto after = std::upper_bound(times_.begin() + 1, times_.end() - 1, plain(seconds));
    const auto i = static_cast<std::size_t>(after - times_.begin()) - 1;
    const T share = (seconds - times_[i]) / (times_[i + 1] - times_[i]);
    const Eigen::Matrix<T, 3, 1> step = share * steps_[i].cast<T>();
    return rotations_[i].cast<T>() * exp_of(step);
  }

 private:
  std::vector<double> times_;
  std::vector<Eigen::Quaterniond> rotations_;
  std::vector<Vector3d> steps_;
};

/// Where the unknowns, all of them small or zero at first, are counted from.
struct Origin {
  Eigen::Quaterniond body_from_camera, earth_from_world;
};

/// A scale that the data set, between limits that keep it sensible.
struct Scale {
  double value, low, high;
};

/// One frame: what the sensor reads beside what it should, in standard deviations.
struct FrameResidual {
  const SensorCurve* sensor;
  const Origin* origin;
  const Scale* sigma;  // radians
  double time;         // of the camera's clock, seconds
  double share;        // of the way from one knot of the drift to the next
  Eigen::Quaterniond world_from_camera;

  template <class T>
  Eigen::Quaternion<T> earth_from_body(const T* mounting, const T* drift0, const T* drift1) const {
    using Vector = Eigen::Matrix<T, 3, 1>;
    const Vector drift = T(1 - share) * Eigen::Map<const Vector>(drift0) + T(share) * Eigen::Map<const Vector>(drift1);
    const Vector turned = Eigen::Map<const Vector>(mounting);
    const Eigen::Quaternion<T> body_from_camera = exp_of(turned) * origin->body_from_camera.cast<T>();
    return exp_of(drift) * (origin->earth_from_world * world_from_camera).cast<T>() * body_from_camera.conjugate();
  }

  template <class T>
  bool operator()(const T* mounting, const T* offset, const T* drift0, const T* drift1, const T* tilt, const T* heading,
                  T* residual) const {
    using Vector = Eigen::Matrix<T, 3, 1>;
    std::array<T, kTiltCoefficients + kHeadingCoefficients> systematic;
    std::copy(heading, heading + kHeadingCoefficients, std::copy(tilt, tilt + kTiltCoefficients, systematic.begin()));
    const Eigen::Quaternion<T> exact = earth_from_body(mounting, drift0, drift1);
    const Eigen::Quaternion<T> predicted = exp_of(periodic_error(systematic.data(), kHarmonics, exact)) * exact;
    const Vector apart = log_of(Eigen::Quaternion<T>(predicted.conjugate() * sensor->at(T(time - offset[0]))));
    Eigen::Map<Vector>(residual, 3) = apart / T(sigma->value);
    return true;
  }
};

/// Values of zero mean, in standard deviations.
template <int N>
struct ZeroPrior {
  const Scale* scale;
  std::array<double, N> sigma;

  template <class T>
  bool operator()(const T* values, T* residual) const {
    for (std::size_t i = 0; i < N; ++i) residual[i] = values[i] / T(scale->value * sigma[i]);
    return true;
  }
};

/// A random walk from one knot to the next.
struct WalkPrior {
  const Scale* scale;  // radians per root of a second
  double seconds;

  template <class T>
  bool operator()(const T* from, const T* to, T* residual) const {
    for (int i = 0; i < 3; ++i) residual[i] = (to[i] - from[i]) / T(scale->value * std::sqrt(seconds));
    return true;
  }
};

/// The k-th harmonic has 1/(2k) of the amplitude: three of them together then reach about the amplitude.
template <int N>
std::array<double, N> coefficient_sigmas() {
  std::array<double, N> sigma;
  for (std::size_t i = 0; i < N; ++i) sigma[i] = 0.5 / static_cast<double>(i / 2 % kHarmonics + 1);
  return sigma;
}

template <std::size_t N>
std::array<double, N> filled(double value) {
  std::array<double, N> out;
  out.fill(value);
  return out;
}

class Refinement {
 public:
  Refinement(const Trajectory& camera, const OrientationStream& sensor, const Matrix3d& body_from_camera,
             double time_offset)
      : frames_(camera), sensor_(sensor.samples(), camera.front().time), offset_(time_offset) {
    place_origin(body_from_camera);
    add_frames();
    add_priors();
  }

  JointEstimate run() {
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
    options.logging_type = ceres::SILENT;
    for (int round = 0; round < kScaleRounds; ++round) {
      if (round > 0) rescale();
      ceres::Solver::Summary summary;
      ceres::Solve(options, &problem_, &summary);
      linearise();
    }
    return estimate();
  }

 private:
  enum Group : std::size_t { kFrames, kTilt, kHeading, kWalk, kWeak, kGroups };

  double seconds(std::size_t i) const { return to_seconds(frames_[i].time - frames_.front().time); }

  void place_origin(const Matrix3d& body_from_camera) {
    origin_.body_from_camera = Eigen::Quaterniond(body_from_camera);
    Matrix3d sum = Matrix3d::Zero();
    for (std::size_t i = 0; i < frames_.size(); ++i)
      sum += sensor_.at(seconds(i) - offset_).toRotationMatrix() * body_from_camera *
             frames_[i].world_from_camera.rotation().transpose();
    origin_.earth_from_world = Eigen::Quaterniond(nearest_rotation(sum));
  }

  void add_frames() {
    const double duration = seconds(frames_.size() - 1);
    const int intervals = std::clamp(static_cast<int>(std::lround(duration / kKnotInterval)), 1, kMaxKnots);
    knot_interval_ = std::max(duration / intervals, 1e-3);
    drift_.assign(static_cast<std::size_t>(intervals) + 1, filled<3>(0));
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      const double position = seconds(i) / knot_interval_;
      const auto knot = static_cast<std::size_t>(std::min(position, intervals - 1.0));
      residuals_.push_back({&sensor_, &origin_, &scales_[kFrames], seconds(i), position - static_cast<double>(knot),
                            Eigen::Quaterniond(frames_[i].world_from_camera.rotation())});
      knots_.push_back(knot);
      add(kFrames,
          new ceres::AutoDiffCostFunction<FrameResidual, 3, 3, 1, 3, 3, kTiltCoefficients, kHeadingCoefficients>(
              new FrameResidual(residuals_.back())),
          new ceres::HuberLoss(kHuberSigmas),
          {mounting_.data(), &offset_, drift_[knot].data(), drift_[knot + 1].data(), tilt_.data(), heading_.data()});
    }
  }

  void add_priors() {
    for (std::size_t k = 0; k + 1 < drift_.size(); ++k)
      add(kWalk, new ceres::AutoDiffCostFunction<WalkPrior, 3, 3, 3>(new WalkPrior{&scales_[kWalk], knot_interval_}),
          nullptr, {drift_[k].data(), drift_[k + 1].data()});
    add_prior(kTilt, coefficient_sigmas<kTiltCoefficients>(), &tilt_);
    add_prior(kHeading, coefficient_sigmas<kHeadingCoefficients>(), &heading_);
    // Next to nothing, so that what a motion does not determine has a large standard deviation in place of none.
    add_prior(kWeak, filled<3>(std::numbers::pi), &mounting_);
    add_prior(kWeak, filled<3>(std::numbers::pi), &drift_.front());
    add(kWeak, new ceres::AutoDiffCostFunction<ZeroPrior<1>, 1, 1>(new ZeroPrior<1>{&scales_[kWeak], {1.0}}), nullptr,
        {&offset_});
  }

  template <std::size_t N>
  void add_prior(Group group, const std::array<double, N>& sigma, std::array<double, N>* values) {
    constexpr int kSize = static_cast<int>(N);
    add(group,
        new ceres::AutoDiffCostFunction<ZeroPrior<kSize>, kSize, kSize>(new ZeroPrior<kSize>{&scales_[group], sigma}),
        nullptr, {values->data()});
  }

  void add(Group group, ceres::CostFunction* cost, ceres::LossFunction* loss, const std::vector<double*>& blocks) {
    blocks_.push_back(problem_.AddResidualBlock(cost, loss, blocks));
    group_of_row_.insert(group_of_row_.end(), static_cast<std::size_t>(cost->num_residuals()), group);
  }

  /// Residuals, and the covariance of all unknowns: mounting, offset, drift, systematic error.
  void linearise() {
    ceres::Problem::EvaluateOptions options;
    options.residual_blocks = blocks_;
    options.parameter_blocks = {mounting_.data(), &offset_, tilt_.data(), heading_.data()};
    for (auto& knot : drift_) options.parameter_blocks.push_back(knot.data());
    problem_.Evaluate(options, nullptr, &rows_, nullptr, &jacobian_);
    MatrixXd information = MatrixXd::Zero(jacobian_.num_cols, jacobian_.num_cols);
    for_each_pair([&](std::size_t, int i, int j, double product) { information(i, j) += product; });
    covariance_ = information.ldlt().solve(MatrixXd::Identity(information.rows(), information.cols()));
  }

  /// For every row and every pair of its columns: row, i, j, J(row, i) J(row, j).
  template <class Function>
  void for_each_pair(Function&& function) const {
    for (std::size_t row = 0; row < rows_.size(); ++row)
      for (int a = jacobian_.rows[row]; a < jacobian_.rows[row + 1]; ++a)
        for (int b = jacobian_.rows[row]; b < jacobian_.rows[row + 1]; ++b) {
          const auto ia = static_cast<std::size_t>(a), ib = static_cast<std::size_t>(b);
          function(row, jacobian_.cols[ia], jacobian_.cols[ib], jacobian_.values[ia] * jacobian_.values[ib]);
        }
  }

  /// MacKay's fixed point: the variance of a group is its sum of squares over the number of its values that the data,
  /// not the prior, determine; that of the frames, over the rows that are not used up by unknowns.
  void rescale() {
    std::array<double, kGroups> rows{}, squares{}, held{};
    for (std::size_t row = 0; row < rows_.size(); ++row) {
      rows[group_of_row_[row]] += 1;
      squares[group_of_row_[row]] += rows_[row] * rows_[row];
    }
    for_each_pair([&](std::size_t row, int i, int j, double product) {
      held[group_of_row_[row]] += product * covariance_(i, j);
    });
    for (const Group group : {kTilt, kHeading, kWalk})
      if (const double determined = rows[group] - held[group]; determined > 0.5)
        set(group, scales_[group].value * std::sqrt(squares[group] / determined));
    const double free = std::max(rows[kFrames] - held[kFrames], rows[kFrames] / 4);
    redundancy_ = correlated();
    // The scale is that of the noise as if every frame told something new.
    set(kFrames, scales_[kFrames].value * std::sqrt(squares[kFrames] / free * redundancy_));
  }

  void set(Group group, double value) {
    scales_[group].value = std::clamp(value, scales_[group].low, scales_[group].high);
  }

  /// Sum of the autocorrelation of the frames' residuals: so many of them tell no more than one.
  double correlated() const {
    const std::size_t n = frames_.size();
    const auto product = [&](std::size_t lag) {
      double sum = 0;
      for (std::size_t i = 0; i + 3 * lag < 3 * n; ++i) sum += rows_[i] * rows_[i + 3 * lag];
      return sum;
    };
    const double square = product(0);
    double sum = 1;
    for (std::size_t lag = 1; lag < n / 4 && square > 0; ++lag) {
      const double share = product(lag) / square;
      if (share < 0.05) break;
      sum += 2 * share;
    }
    return sum;
  }

  JointEstimate estimate() const {
    JointEstimate out;
    out.body_from_camera = so3::exp(Vector3d(mounting_.data())) * origin_.body_from_camera.toRotationMatrix();
    out.time_offset = offset_;
    out.covariance = covariance_.topLeftCorner<3, 3>();
    out.time_offset_sd = std::sqrt(covariance_(3, 3));
    out.redundancy = redundancy_;
    for (const auto& knot : drift_)
      out.drift = std::max(out.drift, (Vector3d(knot.data()) - Vector3d(drift_.front().data())).norm());
    std::array<double, kTiltCoefficients + kHeadingCoefficients> systematic;
    std::copy(heading_.begin(), heading_.end(), std::copy(tilt_.begin(), tilt_.end(), systematic.begin()));
    double sum = 0;
    for (std::size_t i = 0; i < residuals_.size(); ++i) {
      const double *drift0 = drift_[knots_[i]].data(), *drift1 = drift_[knots_[i] + 1].data();
      Vector3d apart;
      residuals_[i](mounting_.data(), &offset_, drift0, drift1, tilt_.data(), heading_.data(), apart.data());
      sum += apart.squaredNorm() * scales_[kFrames].value * scales_[kFrames].value;
      const Eigen::Quaterniond exact = residuals_[i].earth_from_body(mounting_.data(), drift0, drift1);
      out.systematic = out.systematic.cwiseMax(periodic_error(systematic.data(), kHarmonics, exact).cwiseAbs()).eval();
    }
    out.residual = std::sqrt(sum / static_cast<double>(frames_.size()));
    return out;
  }

  Trajectory frames_;
  SensorCurve sensor_;
  Origin origin_;
  // The first guess is a chip such as the BNO055 behind a good tracker; then the data decide.
  std::array<Scale, kGroups> scales_ = {{{radians(0.2), radians(0.01), radians(10)},
                                         {radians(3), radians(0.02), radians(15)},
                                         {radians(10), radians(0.02), radians(30)},
                                         {radians(0.1), radians(0.01), radians(1)},
                                         {1, 1, 1}}};
  // Unknowns.
  std::array<double, 3> mounting_{};  // rotation vector, body axes, on the left of the origin's
  double offset_;
  std::vector<std::array<double, 3>> drift_;  // rotation vectors, earth axes, one a knot
  std::array<double, kTiltCoefficients> tilt_{};
  std::array<double, kHeadingCoefficients> heading_{};

  double knot_interval_ = 1, redundancy_ = 1;
  std::vector<FrameResidual> residuals_;
  std::vector<std::size_t> knots_;  // of each frame, the earlier one
  ceres::Problem problem_;
  std::vector<ceres::ResidualBlockId> blocks_;
  std::vector<Group> group_of_row_;
  std::vector<double> rows_;
  ceres::CRSMatrix jacobian_;
  MatrixXd covariance_;
};

}  // namespace

JointEstimate refine_jointly(const Trajectory& camera, const OrientationStream& sensor,
                             const Matrix3d& body_from_camera, double time_offset) {
  return Refinement(camera, sensor, body_from_camera, time_offset).run();
}

}  // namespace plumbline
