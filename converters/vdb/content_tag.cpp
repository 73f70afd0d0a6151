// SPDX-License-Identifier: Apache-2.0
#include "content_tag.h"

#include <boost/uuid/name_generator_sha1.hpp>
#include <boost/uuid/uuid_io.hpp>

#include <octet/core/forms/with_degree.h>
#include <octet/version.h>

namespace octet {
namespace {

/// Collects values as bytes. Texts and lists come with their lengths, so that no two sequences of
/// values make the same bytes.
class Bytes {
 public:
  template <typename T>
  std::enable_if_t<std::is_arithmetic_v<T> || std::is_enum_v<T>> add(const T& value) {
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  void add(const std::string& text) {
    add(text.size());
    bytes_ += text;
  }
  /// Values without gaps between their members.
  template <typename List>
  void addAll(const List& list) {
    using Value = std::decay_t<decltype(*list.begin())>;
    static_assert(std::is_arithmetic_v<Value> || std::is_same_v<Value, Vec3> ||
                  std::has_unique_object_representations_v<Value>);
    const std::size_t count = list.size();
    add(count);
    if (count > 0) {
      bytes_.append(reinterpret_cast<const char*>(&*list.begin()), count * sizeof(Value));
    }
  }
  std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

std::string tagOf(const std::string& bytes) {
  // A name space of our own: what other programs hash makes other tags.
  static const auto kSpace =
      boost::uuids::name_generator_sha1(boost::uuids::ns::url())("https://octetvdb/content");
  return to_string(boost::uuids::name_generator_sha1(kSpace)(bytes));
}

void add(Bytes* bytes, const ControlMesh& mesh) {
  const Complex& c = *mesh.complex();
  bytes->addAll(mesh.positions());
  bytes->addAll(c.tets);
  bytes->addAll(c.octs);
  bytes->addAll(c.edges);
  bytes->addAll(c.edgeFlags);  // creases
  bytes->addAll(mesh.corners());
}

/// Every option is named here, so that a new one does not compile before it is thought of.
void add(Bytes* bytes, const BakeOptions& options) {
  const auto& [forms, derivative, voxelSize, resolution, levels, boundary, wallSurface, sampling,
               reconstruction, target, method, half, project, frames, skipExisting, zeta, region,
               shard] = options;
  (void)forms, (void)voxelSize, (void)resolution, (void)levels;  // in forms and plan, resolved
  (void)frames, (void)skipExisting, (void)shard;                 // choose among files and parts
  bytes->add(derivative);
  bytes->add(boundary.name);
  bytes->add(wallSurface);
  bytes->add(sampling);
  bytes->add(reconstruction);
  bytes->add(target);
  bytes->add(method);
  bytes->add(half);
  bytes->add(project);
  bytes->add(zeta);
  bytes->add(region.has_value());
  if (region) bytes->addAll(std::array<Vec3, 2>{region->min, region->max});
}

}  // namespace

ContentTags::ContentTags(const ControlAsset& asset, const BakeOptions& options,
                         const ResolutionPlan& plan, std::vector<TaggedForm> forms)
    : asset_(asset), forms_(std::move(forms)) {
  Bytes bytes;
  bytes.add(std::string(kVersion));
  bytes.add(asset.name);
  bytes.add(asset.units.upAxis);
  bytes.add(asset.units.metersPerUnit);
  bytes.add(asset.units.framesPerSecond);
  add(&bytes, asset.mesh);
  add(&bytes, options);
  bytes.add(plan.voxelSize);
  bytes.add(plan.levels);
  for (const TaggedForm& tagged : forms_) {
    bytes.add(tagged.form->name);
    bytes.add(tagged.form->unit);
    bytes.add(tagged.form->degree);
    bytes.add(tagged.grid);
    bytes.add(tagged.mode);
  }
  common_ = tagOf(bytes.take());
}

std::string ContentTags::of(std::optional<int> frame) const {
  Bytes bytes;
  bytes.add(common_);
  bytes.add(frame.has_value());
  bytes.add(frame.value_or(0));
  for (const TaggedForm& tagged : forms_) {
    withDegree(tagged.form->degree, [&](auto degree) {
      constexpr int K = decltype(degree)::value;
      bytes.addAll(coefficients<K>(asset_, *tagged.form, frame.value_or(0)).values());
    });
  }
  return tagOf(bytes.take());
}

}  // namespace octet
