// SPDX-License-Identifier: Apache-2.0
// What octetvdb and octetvdb-gmsh say to each other: it survives the way in pieces of any size, and
// what is cut off or malformed is refused, never taken for something else.
#include <gtest/gtest.h>

#include <octet/converters/gmsh/messages.h>
#include <octet/core/base/error.h>

namespace octet::gmsh_import {
namespace {

GmshMesh someMesh() {
  GmshMesh mesh;
  mesh.messages = {"Info: read", ""};
  mesh.nodeTags = {1, 2, 7, 1ull << 60};
  mesh.coordinates = {0, -1.5, 1e-300, 3, 4, 5, 6, 7, 8, 9, 10, 11};
  mesh.blocks.resize(2);
  mesh.blocks[1] = {4, 3, 4, "Tetrahedron 4", {11}, {1, 2, 7, 1ull << 60}};
  mesh.views.push_back({"flux", "ElementData", {{3, 1, {11}, {0.25}}}});
  mesh.groups.push_back({1, "creases", {mesh.blocks[1]}});
  return mesh;
}

RemeshedSurface someSurface() {
  RemeshedSurface surface;
  surface.surface.vertices = {Vec3(0, 0, 1), Vec3(1, 2, 3), Vec3(-4, 5, -6)};
  surface.surface.triangles = {{0, 1, 2}, {2, 1, 0}};
  surface.creases = {{0, 2}};
  surface.corners = {1};
  return surface;
}

TEST(Content, ComesBackAsItWas) {
  const GmshMesh mesh = unpack<GmshMesh>(pack(someMesh()));
  EXPECT_EQ(mesh.messages, someMesh().messages);
  EXPECT_EQ(mesh.nodeTags, someMesh().nodeTags);
  EXPECT_EQ(mesh.coordinates, someMesh().coordinates);
  ASSERT_EQ(mesh.blocks.size(), 2u);
  EXPECT_EQ(mesh.blocks[1].typeName, "Tetrahedron 4");
  EXPECT_EQ(mesh.blocks[1].nodes, someMesh().blocks[1].nodes);
  EXPECT_EQ(mesh.views.at(0).steps.at(0).values, std::vector<double>{0.25});
  EXPECT_EQ(mesh.groups.at(0).blocks.at(0).tags, std::vector<Tag>{11});
  const RemeshedSurface surface = unpack<RemeshedSurface>(pack(someSurface()));
  EXPECT_EQ(surface.surface.vertices, someSurface().surface.vertices);
  EXPECT_EQ(surface.surface.triangles, someSurface().surface.triangles);
  EXPECT_EQ(surface.creases, someSurface().creases);
  EXPECT_EQ(surface.corners, someSurface().corners);
}

template <typename T>
void expectDamageRefused(const T& content) {
  const std::string bytes = pack(content);
  for (std::size_t n = 0; n < bytes.size(); ++n) {
    EXPECT_THROW(unpack<T>(bytes.substr(0, n)), InputError) << n;
  }
  EXPECT_THROW(unpack<T>(bytes + '\0'), InputError);
}

TEST(Content, IsRefusedWhenCutOffOrLonger) {
  expectDamageRefused(someMesh());
  expectDamageRefused(someSurface());
  expectDamageRefused(FillRequest{{{1, 2, 3}, {{1, 2, 3}}, {{0}}, 0.5}, 7});
  expectDamageRefused(MeshRequest{"a.msh", 7});
  expectDamageRefused(SurfaceRequest{someSurface().surface, 1, 2});
  expectDamageRefused(WorkDone{1, 2});
  expectDamageRefused(WorkFailure{1, "here", "so"});
}

/// No number of entries in it is taken on trust: any other byte anywhere is refused or makes
/// something that fits into memory.
TEST(Content, OfOtherBytesAsksForNoMemory) {
  const std::string good = pack(someMesh());
  for (std::size_t k = 0; k < good.size(); ++k) {
    for (const char byte : {'\x00', '\x01', '\x7f', '\xff'}) {
      std::string bytes = good;
      bytes[k] = byte;
      try {
        EXPECT_LE(pack(unpack<GmshMesh>(bytes)).size(), good.size());
      } catch (const InputError&) {
      }
    }
  }
}

TEST(Messages, ComeInPiecesOfAnySize) {
  const std::string bytes = message(MessageKind::Hello, "") +
                            message(MessageKind::Progress, pack(WorkDone{3, 10})) +
                            message(MessageKind::Answer, pack(someMesh()));
  for (const std::size_t piece : {std::size_t{1}, std::size_t{7}, bytes.size()}) {
    MessageReader reader(1 << 20);
    std::vector<Message> all;
    for (std::size_t at = 0; at < bytes.size(); at += piece) {
      reader.take(std::string_view(bytes).substr(at, piece));
      while (auto next = reader.next()) all.push_back(*next);
    }
    ASSERT_EQ(all.size(), 3u);
    EXPECT_EQ(all[0].kind, MessageKind::Hello);
    EXPECT_EQ(unpack<WorkDone>(all[1].content).total, 10u);
    EXPECT_EQ(all[2].kind, MessageKind::Answer);
    EXPECT_EQ(all[2].content, pack(someMesh()));
  }
}

TEST(Messages, AreRefusedByTheirHead) {
  const std::string good = message(MessageKind::Answer, "four");
  const auto refused = [](const std::string& bytes, const std::string& why) {
    MessageReader reader(100);
    reader.take(bytes);
    try {
      reader.next();
      ADD_FAILURE() << "taken, although it " << why;
    } catch (const InputError& e) {
      EXPECT_NE(e.reason().find(why), std::string::npos) << e.what();
    }
  };
  const auto with = [&](std::size_t at, char byte) {
    std::string bytes = good;
    bytes[at] = byte;
    return bytes;
  };
  refused("Segmentation fault, and more text", "is none");
  refused(with(0, 'X'), "is none");
  refused(with(4, 99), "is of version 99 instead of 1");
  refused(with(8, 99), "unknown kind");
  refused(with(12, 101), "too large");
  refused(with(19, 127), "too large");
  MessageReader reader(100);
  reader.take(good.substr(0, good.size() - 1));
  EXPECT_FALSE(reader.next());
  reader.take("r");
  EXPECT_EQ(reader.next()->content, "four");
  EXPECT_FALSE(reader.next());
}

}  // namespace
}  // namespace octet::gmsh_import
