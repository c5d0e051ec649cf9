// How far the images can be trusted beside a prediction, from what they leave unexplained.
#pragma once

namespace plumbline {

/// How well frames fit the model: the residuals of the latest ones. What they have beyond a good sensor's noise is no
/// noise of single pixels but error that successive frames share (docs/method.md §8).
class ModelFit {
 public:
  /// `rms`: metres, point-to-plane, of an accepted frame.
  void observe(double rms, double seconds);
  /// 0 where frames fit as well as a good sensor's, 1 where half of the residual's square and more is shared error, and
  /// before anything is known.
  double repeated_share() const;

 private:
  /// Metres: frames of a Kinect in a room are below, in views of its far end and of a phone's LiDAR above.
  static constexpr double kNoise = 0.009;
  double square_ = 2 * kNoise * kNoise;  ///< metres², a mean over the latest frames
};

}  // namespace plumbline
