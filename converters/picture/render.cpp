// SPDX-License-Identifier: Apache-2.0
#include "render.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include <tbb/task_arena.h>

#include <octet/core/base/reported_loop.h>

#include "embree.h"

namespace octet {
namespace {

// Light: of a lit face turned fully to the key light, ambient + key = 1.
constexpr double kAmbient = 0.5, kKey = 0.5, kGloss = 0.12, kShininess = 40;
/// A mirror direction that far from the light has no gloss that can be seen: its power is 1e-4.
constexpr double kNoGloss = 0.8;
/// Where the key light stands: right, up, towards the viewer.
const Vec3 kKeyDirection = Vec3(-0.45, 0.75, 0.6).normalized();
/// Rays that look for blocked ambient light, and how far they look; the whole is about 1 across.
constexpr int kAmbientRays = 6;
constexpr float kAmbientReach = 0.12f;
/// Start of secondary rays off the face that they leave.
constexpr float kOffset = 1e-4f;
/// A transparent surface's opacity grows up to this, seen edge on.
constexpr double kEdgeOpacity = 0.5;
/// Most transparent layers along a ray, and how far apart hits are to count as two.
constexpr int kMostLayers = 32;
constexpr float kSameHit = 1e-6f;
/// More rays where colours in the neighbourhood differ by more than this, in linear light.
constexpr float kContrast = 0.02f;
constexpr int kTile = 16;

/// Embree reports through return codes and this.
[[noreturn]] void fail(RTCDevice device) {
  const RTCError code = rtcGetDeviceError(device);
  if (code == RTC_ERROR_OUT_OF_MEMORY) throw std::bad_alloc();
  throw Error("", "Embree", "error " + std::to_string(static_cast<int>(code)));
}

struct Deleter {
  void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
  void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
  void operator()(RTCGeometry geometry) const { rtcReleaseGeometry(geometry); }
};
using Device = std::unique_ptr<std::remove_pointer_t<RTCDevice>, Deleter>;
using SceneHandle = std::unique_ptr<std::remove_pointer_t<RTCScene>, Deleter>;
using Geometry = std::unique_ptr<std::remove_pointer_t<RTCGeometry>, Deleter>;

void store(const Vec3& v, float* out) {
  for (int k = 0; k < 3; ++k) out[k] = static_cast<float>(v[k]);
}
Vec3 load(const float* v) { return {v[0], v[1], v[2]}; }

/// Hits of a ray on the transparent surface, all of them.
struct Layers : RayContext {
  struct Layer {
    float t, u, v;
    unsigned triangle;
    float normal[3];
  };
  int count = 0;
  std::array<Layer, kMostLayers> layers;
};

void collectLayer(const RTCFilterFunctionNArguments* args) {
  // Called for single rays only. Refusing every hit lets the ray find all.
  auto& found = *static_cast<Layers*>(args->context);
  const auto* ray = reinterpret_cast<const RTCRay*>(args->ray);
  const auto* hit = reinterpret_cast<const RTCHit*>(args->hit);
  args->valid[0] = 0;
  if (found.count == kMostLayers) return;
  found.layers[found.count++] = {
      ray->tfar, hit->u, hit->v, hit->primID, {hit->Ng_x, hit->Ng_y, hit->Ng_z}};
}

class Tracer {
 public:
  explicit Tracer(const Scene& scene) : scene_(scene), device_(rtcNewDevice(nullptr)) {
    if (!device_) fail(nullptr);
    solid_.reset(rtcNewScene(device_.get()));
    glass_.reset(rtcNewScene(device_.get()));
    if (!solid_ || !glass_) fail(device_.get());
    addTubes();
    addCones();
    addSurface();
    // Built by one thread, so that the tree is the same every time.
    tbb::task_arena(1).execute([&] {
      rtcJoinCommitScene(solid_.get());
      rtcJoinCommitScene(glass_.get());
    });
    if (rtcGetDeviceError(device_.get()) != RTC_ERROR_NONE) fail(device_.get());
  }

  /// Light along a ray, premultiplied, and how much it covers.
  Eigen::Array4f trace(const Vec3& from, const Vec3& direction, const View& view) const {
    RTCRayHit ray = makeRay(from, direction, 0, HUGE_VALF);
    RayContext context;
    intersect(solid_.get(), &context, &ray);
    Eigen::Array4f light = Eigen::Array4f::Zero();
    float left = 1;
    addGlass(from, direction, ray.ray.tfar, view, &light, &left);
    if (ray.hit.geomID != RTC_INVALID_GEOMETRY_ID) {
      const Vec3 colour = shade(ray, direction.normalized(), view);
      for (int c = 0; c < 3; ++c) light[c] += left * static_cast<float>(colour[c]);
      light[3] += left;
    }
    return light;
  }

 private:
  enum Kind : unsigned { kLitTubes, kDrawnTubes, kCones, kSurface };

  static RTCRayHit makeRay(const Vec3& from, const Vec3& direction, float near, float far) {
    RTCRayHit ray{};
    ray.ray.org_x = static_cast<float>(from[0]);
    ray.ray.org_y = static_cast<float>(from[1]);
    ray.ray.org_z = static_cast<float>(from[2]);
    ray.ray.dir_x = static_cast<float>(direction[0]);
    ray.ray.dir_y = static_cast<float>(direction[1]);
    ray.ray.dir_z = static_cast<float>(direction[2]);
    ray.ray.tnear = near;
    ray.ray.tfar = far;
    ray.ray.mask = ~0u;
    ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    return ray;
  }

  template <typename T>
  T* buffer(const Geometry& geometry, RTCBufferType type, RTCFormat format, std::size_t count) {
    void* const data = rtcSetNewGeometryBuffer(geometry.get(), type, 0, format, sizeof(T), count);
    if (!data) fail(device_.get());
    return static_cast<T*>(data);
  }
  void attach(const SceneHandle& to, const Geometry& geometry, Kind kind) {
    rtcCommitGeometry(geometry.get());
    rtcAttachGeometryByID(to.get(), geometry.get(), kind);
  }
  Geometry geometry(RTCGeometryType type) {
    Geometry result(rtcNewGeometry(device_.get(), type));
    if (!result) fail(device_.get());
    return result;
  }

  void addTubes() {
    for (const bool lit : {true, false}) {
      std::vector<std::array<float, 4>> points;
      std::vector<unsigned> segments;
      std::vector<unsigned char> flags;
      std::vector<Vec3>& colours = lit ? litColours_ : drawnColours_;
      for (const Scene::Tube& tube : scene_.tubes) {
        if (tube.lit != lit || tube.points.size() < 2) continue;
        for (std::size_t k = 0; k < tube.points.size(); ++k) {
          if (k + 1 < tube.points.size()) {
            segments.push_back(static_cast<unsigned>(points.size()));
            flags.push_back(static_cast<unsigned char>(
                (k > 0 ? RTC_CURVE_FLAG_NEIGHBOR_LEFT : 0) |
                (k + 2 < tube.points.size() ? RTC_CURVE_FLAG_NEIGHBOR_RIGHT : 0)));
          }
          std::array<float, 4> point;
          store(tube.points[k], point.data());
          point[3] = static_cast<float>(tube.radius);
          points.push_back(point);
          colours.push_back(tube.colours[tube.colours.size() == 1 ? 0 : k]);
        }
      }
      if (segments.empty()) continue;
      const Geometry g = geometry(RTC_GEOMETRY_TYPE_ROUND_LINEAR_CURVE);
      fillCurves(g, points, segments);
      std::copy(flags.begin(), flags.end(),
                buffer<unsigned char>(g, RTC_BUFFER_TYPE_FLAGS, RTC_FORMAT_UCHAR, flags.size()));
      attach(solid_, g, lit ? kLitTubes : kDrawnTubes);
      (lit ? litSegments_ : drawnSegments_) = std::move(segments);
    }
  }

  void addCones() {
    std::vector<std::array<float, 4>> points;
    std::vector<unsigned> segments;
    for (const Scene::Cone& cone : scene_.cones) {
      segments.push_back(static_cast<unsigned>(points.size()));
      std::array<float, 4> from, to;
      store(cone.from, from.data());
      store(cone.to, to.data());
      from[3] = static_cast<float>(cone.radiusFrom);
      to[3] = static_cast<float>(cone.radiusTo);
      points.push_back(from);
      points.push_back(to);
    }
    if (segments.empty()) return;
    const Geometry g = geometry(RTC_GEOMETRY_TYPE_CONE_LINEAR_CURVE);
    fillCurves(g, points, segments);
    attach(solid_, g, kCones);
  }

  void fillCurves(const Geometry& g, const std::vector<std::array<float, 4>>& points,
                  const std::vector<unsigned>& segments) {
    std::copy(
        points.begin(), points.end(),
        buffer<std::array<float, 4>>(g, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT4, points.size()));
    std::copy(segments.begin(), segments.end(),
              buffer<unsigned>(g, RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT, segments.size()));
  }

  void addSurface() {
    const Scene::Surface& s = scene_.surface;
    if (s.triangles.empty()) return;
    const Geometry g = geometry(RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* points =
        buffer<std::array<float, 3>>(g, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, s.points.size());
    for (std::size_t k = 0; k < s.points.size(); ++k) store(s.points[k], points[k].data());
    auto* corners = buffer<std::array<unsigned, 3>>(g, RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3,
                                                    s.triangles.size());
    for (std::size_t k = 0; k < s.triangles.size(); ++k) {
      for (int i = 0; i < 3; ++i) corners[k][i] = static_cast<unsigned>(s.triangles[k][i]);
    }
    const bool glass = s.opacity < 1;
    if (glass) rtcSetGeometryIntersectFilterFunction(g.get(), collectLayer);
    attach(glass ? glass_ : solid_, g, kSurface);
  }

  Vec3 surfaceColour(unsigned triangle, float u, float v) const {
    const Scene::Surface& s = scene_.surface;
    if (s.colours.size() == 1) return s.colours[0];
    const auto& [a, b, c] = s.triangles[triangle];
    return (1 - u - v) * s.colours[a] + u * s.colours[b] + v * s.colours[c];
  }

  Vec3 colourOf(const RTCHit& hit) const {
    const auto along = [&](const std::vector<unsigned>& segments,
                           const std::vector<Vec3>& colours) {
      const unsigned k = segments[hit.primID];
      return Vec3((1 - hit.u) * colours[k] + hit.u * colours[k + 1]);
    };
    switch (hit.geomID) {
      case kLitTubes:
        return along(litSegments_, litColours_);
      case kDrawnTubes:
        return along(drawnSegments_, drawnColours_);
      case kCones:
        return scene_.cones[hit.primID].colour;
      default:
        return surfaceColour(hit.primID, hit.u, hit.v);
    }
  }

  Vec3 shade(const RTCRayHit& ray, const Vec3& direction, const View& view) const {
    const Vec3 colour = colourOf(ray.hit);
    if (ray.hit.geomID == kDrawnTubes) return colour;
    Vec3 normal = Vec3(ray.hit.Ng_x, ray.hit.Ng_y, ray.hit.Ng_z).normalized();
    if (normal.dot(direction) > 0) normal = -normal;
    const Vec3 at = load(&ray.ray.org_x) + ray.ray.tfar * load(&ray.ray.dir_x);
    return lit(colour, normal, direction, view, 1 - blocked(at, normal));
  }

  /// Light from a face.
  static Vec3 lit(const Vec3& colour, const Vec3& normal, const Vec3& direction, const View& view,
                  double open) {
    const Vec3 key = kKeyDirection[0] * view.right() + kKeyDirection[1] * view.up() +
                     kKeyDirection[2] * view.back();
    const double facing = normal.dot(key);
    // Half of the light wraps around, which keeps the dark side readable.
    const double diffuse = std::max(0.0, (facing + 0.5) / 1.5);
    const Vec3 matte = open * (kAmbient + kKey * diffuse) * colour;
    const double mirrored = normal.dot((key - direction).normalized());
    if (!(facing > 0) || mirrored < kNoGloss) return matte;
    return matte + Vec3::Constant(open * kGloss * std::pow(mirrored, kShininess));
  }

  /// Part of the ambient light that something near blocks: cosine-distributed rays, the same at
  /// every point, so that they make no noise.
  double blocked(const Vec3& at, const Vec3& normal) const {
    const Vec3 side = normal.unitOrthogonal(), other = normal.cross(side);
    int hits = 0;
    for (int k = 0; k < kAmbientRays; ++k) {
      const double height = std::sqrt(1 - (k + 0.5) / kAmbientRays);
      const double angle = 2.399963229728653 * k;  // the golden angle
      const double radius = std::sqrt(1 - height * height);
      const Vec3 d = height * normal + radius * (std::cos(angle) * side + std::sin(angle) * other);
      RTCRayHit ray = makeRay(at + kOffset * normal, d, kOffset, kAmbientReach);
      occluded(solid_.get(), &ray.ray);
      hits += ray.ray.tfar < 0 ? 1 : 0;
    }
    return 0.6 * hits / kAmbientRays;
  }

  /// Blends the transparent surface's layers in front of `far`, nearest first.
  void addGlass(const Vec3& from, const Vec3& direction, float far, const View& view,
                Eigen::Array4f* light, float* left) const {
    if (!(scene_.surface.opacity < 1) || scene_.surface.triangles.empty()) return;
    Layers found;
    RTCRayHit ray = makeRay(from, direction, 0, far);
    intersect(glass_.get(), &found, &ray);
    const auto end = found.layers.begin() + found.count;
    std::sort(found.layers.begin(), end, [](const Layers::Layer& a, const Layers::Layer& b) {
      return std::pair(a.t, a.triangle) < std::pair(b.t, b.triangle);
    });
    const Vec3 unit = direction.normalized();
    float last = -1;
    for (auto layer = found.layers.begin(); layer != end; ++layer) {
      if (layer->t - last < kSameHit) continue;  // an edge between two triangles
      last = layer->t;
      Vec3 normal = load(layer->normal).normalized();
      if (normal.dot(unit) > 0) normal = -normal;
      const double aside = 1 + normal.dot(unit);  // 0 face on, 1 edge on
      const double opacity =
          scene_.surface.opacity + (kEdgeOpacity - scene_.surface.opacity) * aside * aside * aside;
      const Vec3 colour =
          lit(surfaceColour(layer->triangle, layer->u, layer->v), normal, unit, view, 1);
      for (int c = 0; c < 3; ++c) {
        (*light)[c] += *left * static_cast<float>(opacity * colour[c]);
      }
      (*light)[3] += *left * static_cast<float>(opacity);
      *left *= static_cast<float>(1 - opacity);
    }
  }

  const Scene& scene_;
  Device device_;
  SceneHandle solid_, glass_;  // what blocks light, and what is seen through
  std::vector<Vec3> litColours_, drawnColours_;
  std::vector<unsigned> litSegments_, drawnSegments_;
};

/// Places in a pixel: one in each of 4 x 4 squares and in each of 16 rows and columns; the first 4
/// are one in each of 4 rows and columns.
constexpr int kFew = 4, kMany = 16;
constexpr double kPlaces[kMany][2] = {
    {0.15625, 0.40625}, {0.40625, 0.84375}, {0.59375, 0.15625}, {0.84375, 0.59375},
    {0.03125, 0.03125}, {0.28125, 0.09375}, {0.53125, 0.28125}, {0.78125, 0.21875},
    {0.09375, 0.71875}, {0.34375, 0.53125}, {0.65625, 0.65625}, {0.90625, 0.34375},
    {0.21875, 0.96875}, {0.46875, 0.46875}, {0.71875, 0.90625}, {0.96875, 0.78125}};

/// Calls `tile(x, y, toX, toY)` for all tiles in parallel.
void forTiles(int width, int height, const Context& context, const std::string& stage,
              const std::function<void(int, int, int, int)>& tile) {
  const int columns = (width + kTile - 1) / kTile, rows = (height + kTile - 1) / kTile;
  for (int row = 0; row < rows; ++row) {
    context.report(
        {stage, static_cast<std::size_t>(row), static_cast<std::size_t>(rows), "rows of tiles"});
    parallelFor<int>(
        columns,
        [&](int column) {
          tile(column * kTile, row * kTile, std::min(width, (column + 1) * kTile),
               std::min(height, (row + 1) * kTile));
        },
        context, 1);
  }
  context.report(
      {stage, static_cast<std::size_t>(rows), static_cast<std::size_t>(rows), "rows of tiles"});
}

}  // namespace

RenderedImage render(const Scene& scene, const View& view, int width, int height,
                     const Context& context) {
  const Tracer tracer(scene);
  const std::size_t count = static_cast<std::size_t>(width) * height;
  // Of the rays in each pixel the sum, and the range, to find edges.
  std::vector<Eigen::Array4f> sums(count), low(count), high(count);
  const auto background = scene.background.cast<float>().eval();
  const auto seen = [&](const Eigen::Array4f& light) {
    Eigen::Array4f result = light;
    result.head<3>() += (1 - light[3]) * background.array();
    return result;
  };
  const auto ray = [&](int x, int y, int k) {
    return tracer.trace(view.eye(), view.direction(x + kPlaces[k][0], y + kPlaces[k][1]), view);
  };
  forTiles(width, height, context, "trace rays", [&](int left, int top, int right, int bottom) {
    for (int y = top; y < bottom; ++y) {
      for (int x = left; x < right; ++x) {
        const std::size_t at = static_cast<std::size_t>(y) * width + x;
        sums[at].setZero();
        low[at].setConstant(HUGE_VALF);
        high[at].setConstant(-HUGE_VALF);
        for (int k = 0; k < kFew; ++k) {
          const Eigen::Array4f light = ray(x, y, k);
          sums[at] += light;
          low[at] = low[at].min(seen(light));
          high[at] = high[at].max(seen(light));
        }
      }
    }
  });
  RenderedImage image{width, height, {}};
  image.pixels.resize(count);
  const auto differs = [&](int x, int y) {
    Eigen::Array4f least = Eigen::Array4f::Constant(HUGE_VALF), most = -least;
    for (int j = std::max(0, y - 1); j <= std::min(height - 1, y + 1); ++j) {
      for (int i = std::max(0, x - 1); i <= std::min(width - 1, x + 1); ++i) {
        const std::size_t at = static_cast<std::size_t>(j) * width + i;
        least = least.min(low[at]);
        most = most.max(high[at]);
      }
    }
    return (most - least).head<3>().maxCoeff() > kContrast;
  };
  forTiles(width, height, context, "smooth edges", [&](int left, int top, int right, int bottom) {
    for (int y = top; y < bottom; ++y) {
      for (int x = left; x < right; ++x) {
        const std::size_t at = static_cast<std::size_t>(y) * width + x;
        Eigen::Array4f sum = sums[at];
        int rays = kFew;
        if (differs(x, y)) {
          for (; rays < kMany; ++rays) sum += ray(x, y, rays);
        }
        for (int c = 0; c < 4; ++c) image.pixels[at][c] = sum[c] / static_cast<float>(rays);
      }
    }
  });
  return image;
}

}  // namespace octet
