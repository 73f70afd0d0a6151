// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include <octet/core/streamlines/placement.h>

#include "solid_picture.h"

namespace octet {
namespace {

/// Thickness of lines, in parts of the domain's diagonal.
constexpr double kLineRadius = 0.0030, kCageRadius = 0.0009, kMeshRadius = 0.0004;
/// Streamlines: how many, how near seeds come to earlier lines, how long they get, and their
/// points' distance; lengths in parts of the diagonal.
constexpr std::size_t kLines = 60;
constexpr double kSeparation = 0.06, kShortest = 0.05, kLongest = 0.6, kPointDistance = 0.006;
/// Error of one step, in parts of the diagonal.
constexpr double kTolerance = 1e-6;
/// Slower than this part of the highest speed counts as standing still.
constexpr double kStill = 1e-4;
/// A line that comes back this near to its seed is closed.
constexpr double kClosing = 0.002;
/// An arrow head on a line every so often, and its size in line radii.
constexpr double kHeadDistance = 0.4, kHeadLength = 6.5, kHeadRadius = 2.6;
/// Arrows: how many, and how far apart when so many fill a cube.
constexpr std::size_t kArrows = 300;
constexpr double kPacking = 0.75;
/// Lengths are in proportion to speed. Of this part of the arrows none is longer than their
/// distance allows, but the fastest is no more than so many times that long.
constexpr double kUsual = 0.8, kMostUnusual = 2.5;
constexpr double kArrowLength = 1.25, kShaftRadius = 0.035, kArrowHead = 0.36,
                 kArrowHeadRadius = 0.1;
/// Points that measure the range of values.
constexpr std::size_t kProbes = 4000;

const Vec3 kCageColour(0.13, 0.15, 0.19), kInnerColour(0.42, 0.45, 0.5),
    kMeshColour(0.42, 0.47, 0.55), kGlassColour(0.55, 0.66, 0.80);
constexpr double kGlassOpacity = 0.045;

Vec3 linear(const Vec3& srgb) {
  return {linearFromSrgb(srgb[0]), linearFromSrgb(srgb[1]), linearFromSrgb(srgb[2])};
}

class SceneBuilder {
 public:
  SceneBuilder(const Subject& subject, const PictureOptions& options, const Context& context)
      : subject_(subject),
        options_(options),
        context_(context),
        middle_((subject.bounds.min + subject.bounds.max) / 2),
        diagonal_(subject.bounds.size().norm()) {
    if (!(diagonal_ > 0) || !std::isfinite(diagonal_)) {
      throw InputError("", "the domain is empty or too large to draw");
    }
  }

  SolidScene build() {
    const PictureStyle style = chooseStyle();
    // A vector field that is not drawn needs no colours.
    if (subject_.components == 1 || style != PictureStyle::Plain) result_.scale = scaleOfProbes();
    if (style == PictureStyle::Streamlines) addStreamlines();
    if (style == PictureStyle::Arrows) addArrows();
    addCage();
    if (options_.mesh) addMesh();
    if (options_.surface) addSurface(subject_.components == 1);
    for (const Vec3& p : subject_.shape.points) result_.extent.push_back(placed(p));
    if (result_.extent.empty()) addBoxToExtent();
    return std::move(result_);
  }

 private:
  PictureStyle chooseStyle() const {
    const bool vector = subject_.components == 3;
    switch (options_.style) {
      case PictureStyle::Automatic:
        return vector ? PictureStyle::Streamlines : PictureStyle::Plain;
      case PictureStyle::Lic:
        throw InputError("style", "lic is drawn in slices, not in the 3d view");
      case PictureStyle::Streamlines:
      case PictureStyle::Arrows:
        if (!vector) {
          throw InputError("style", subject_.components == 0
                                        ? "there is no form to draw"
                                        : "streamlines and arrows need a vector, but \"" +
                                              subject_.form + "\" is a scalar");
        }
        return options_.style;
      default:
        return options_.style;
    }
  }

  Vec3 placed(const Vec3& p) const { return (p - middle_) / diagonal_; }

  /// Speed of a vector, value of a scalar.
  bool value(const Vec3& p, double* result) const {
    Vec3 v;
    if (!subject_.sample(p, v.data())) return false;
    *result = subject_.components == 3 ? v.norm() : v[0];
    return true;
  }
  Vec3 colour(double value) const { return linear(result_.scale->at(value)); }

  ColourScale scaleOfProbes() {
    std::vector<double> values;
    double x;
    for (const Vec3& p : haltonPoints(subject_.bounds, kProbes)) {
      if (value(p, &x)) values.push_back(x);
    }
    if (subject_.components == 1) {
      for (const Vec3& p : subject_.shape.points) {
        if (value(p, &x)) values.push_back(x);
      }
    }
    for (const double v : values) fastest_ = std::max(fastest_, v);
    PictureOptions options = options_;
    options.quantity = Quantity::Automatic;
    return colourScale(subject_, options, values);
  }

  VelocityFunction velocity() const {
    return [this](const Vec3& p, Vec3* v) { return subject_.sample(p, v->data()); };
  }

  void addStreamlines() {
    PlacementOptions placement;
    placement.count = options_.count > 0 ? options_.count : kLines;
    // More lines ask for less room each.
    placement.separation =
        kSeparation * diagonal_ *
        std::sqrt(static_cast<double>(kLines) / static_cast<double>(placement.count));
    placement.shortest = kShortest * diagonal_;
    placement.lines.tolerance = kTolerance * diagonal_;
    placement.lines.longestStep = kPointDistance * diagonal_;
    placement.lines.longest = kLongest * diagonal_;
    placement.lines.slowest = kStill * fastest_;
    placement.lines.closing = kClosing * diagonal_;
    for (const Streamline& line :
         placeStreamlines(velocity(), subject_.bounds, placement, context_)) {
      Scene::Tube tube;
      tube.radius = kLineRadius;
      for (const StreamlinePoint& p : line.points) {
        tube.points.push_back(placed(p.position));
        tube.colours.push_back(colour(p.velocity.norm()));
      }
      addHeads(line);
      result_.scene.tubes.push_back(std::move(tube));
    }
  }

  /// Arrow heads along a line, which tell its direction: evenly, one at least.
  void addHeads(const Streamline& line) {
    const double length = line.length() / diagonal_;
    const int count = std::max(1, static_cast<int>(std::lround(length / kHeadDistance)));
    double gone = 0;
    int next = 0;
    for (std::size_t k = 1; k < line.points.size(); ++k) {
      const Vec3 from = placed(line.points[k - 1].position), to = placed(line.points[k].position);
      const double part = (to - from).norm();
      while (next < count && gone + part >= (next + 0.5) * length / count) {
        const Vec3 along = (to - from).normalized();
        const Vec3 at = from + ((next + 0.5) * length / count - gone) * along;
        const Vec3 half = kHeadLength * kLineRadius / 2 * along;
        result_.scene.cones.push_back({at - half, at + half, kHeadRadius * kLineRadius, 0,
                                       colour(line.points[k].velocity.norm())});
        ++next;
      }
      gone += part;
    }
  }

  void addArrows() {
    const std::size_t count = options_.count > 0 ? options_.count : kArrows;
    // Points at this distance, densely packed, are about so many in the part of the box that the
    // domain fills.
    std::size_t inside = 0;
    double x;
    for (const Vec3& p : haltonPoints(subject_.bounds, kProbes)) inside += value(p, &x) ? 1 : 0;
    const double volume = subject_.bounds.size().prod() * static_cast<double>(inside) / kProbes;
    const double distance = kPacking * std::cbrt(volume / static_cast<double>(count));
    const auto isInside = [&](const Vec3& p) {
      double unused;
      return value(p, &unused);
    };
    const std::vector<Vec3> places = spacedPoints(isInside, subject_.bounds, count, distance);
    std::vector<Vec3> vectors(places.size());
    std::vector<double> speeds(places.size());
    for (std::size_t k = 0; k < places.size(); ++k) {
      subject_.sample(places[k], vectors[k].data());
      speeds[k] = vectors[k].norm();
    }
    if (places.empty()) return;
    // A few fast places must not make all others points.
    std::vector<double> sorted = speeds;
    std::sort(sorted.begin(), sorted.end());
    const double usual =
        std::max(sorted[static_cast<std::size_t>(kUsual * static_cast<double>(sorted.size() - 1))],
                 sorted.back() / kMostUnusual);
    if (!(usual > 0)) return;
    const double unit = kArrowLength * distance / diagonal_;
    for (std::size_t k = 0; k < places.size(); ++k) {
      addArrow(placed(places[k]), vectors[k] / usual * unit, unit, colour(speeds[k]));
    }
  }

  /// An arrow centred at a place; a short one keeps its shape.
  void addArrow(const Vec3& at, const Vec3& vector, double unit, const Vec3& colour) {
    const double length = vector.norm();
    if (length < 0.04 * unit) return;
    const double thickness = unit * std::min(1.0, length / (0.5 * unit));
    const Vec3 from = at - vector / 2, to = at + vector / 2;
    const Vec3 neck = to - kArrowHead * thickness * vector / length;
    result_.scene.cones.push_back(
        {from, neck, kShaftRadius * thickness, kShaftRadius * thickness, colour});
    result_.scene.cones.push_back({neck, to, kArrowHeadRadius * thickness, 0, colour});
  }

  void addLine(const SubjectShape::Polyline& line, double radius, const Vec3& srgb) {
    Scene::Tube tube;
    for (const Vec3& p : line) tube.points.push_back(placed(p));
    tube.colours = {linear(srgb)};
    tube.radius = radius;
    tube.lit = false;
    result_.scene.tubes.push_back(std::move(tube));
  }

  void addCage() {
    if (options_.cage == CageLines::None) return;
    const SubjectShape& shape = subject_.shape;
    for (std::size_t k = 0; k < shape.cage.size(); ++k) {
      if (shape.inner[k] && options_.cage != CageLines::All) continue;
      addLine(shape.cage[k], kCageRadius, shape.inner[k] ? kInnerColour : kCageColour);
      for (const Vec3& p : shape.cage[k]) result_.extent.push_back(placed(p));
    }
  }

  void addMesh() {
    for (const auto& line : subject_.shape.mesh) addLine(line, kMeshRadius, kMeshColour);
  }

  void addSurface(bool coloured) {
    const SubjectShape& shape = subject_.shape;
    Scene::Surface& surface = result_.scene.surface;
    for (const Vec3& p : shape.points) surface.points.push_back(placed(p));
    surface.triangles = shape.triangles;
    surface.opacity = coloured ? 1 : kGlassOpacity;
    surface.colours = {linear(kGlassColour)};
    if (!coloured) return;
    surface.colours.clear();
    for (const Vec3& p : shape.points) {
      double x = result_.scale->min;
      value(p, &x);
      surface.colours.push_back(colour(x));
    }
  }

  void addBoxToExtent() {
    for (int corner = 0; corner < 8; ++corner) {
      Vec3 p;
      for (int k = 0; k < 3; ++k) {
        p[k] = corner >> k & 1 ? subject_.bounds.max[k] : subject_.bounds.min[k];
      }
      result_.extent.push_back(placed(p));
    }
  }

  const Subject& subject_;
  const PictureOptions& options_;
  const Context& context_;
  const Vec3 middle_;
  const double diagonal_;
  double fastest_ = 0;
  SolidScene result_;
};

}  // namespace

SolidScene buildScene(const Subject& subject, const PictureOptions& options,
                      const Context& context) {
  return SceneBuilder(subject, options, context).build();
}

}  // namespace octet
