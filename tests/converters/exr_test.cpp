// SPDX-License-Identifier: Apache-2.0
// OpenEXR files read back: by OpenEXR itself and by TinyEXR, which shares no code with it.
#include <array>
#include <cstring>
#include <filesystem>
#include <fstream>

#include <ImfChannelList.h>
#include <ImfDoubleAttribute.h>
#include <ImfFloatVectorAttribute.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputPart.h>
#include <ImfIntAttribute.h>
#include <ImfMultiPartInputFile.h>
#include <ImfStringAttribute.h>
#include <ImfVecAttribute.h>
#include <gtest/gtest.h>
#include <tinyexr.h>

#include <octet/converters/exr/exr_file.h>
#include <octet/converters/exr/slice_exr.h>
#include <octet/core/base/error.h>

namespace octet {
namespace {

namespace fs = std::filesystem;

/// A part as some reader understands it; channels by name, in the file's order.
struct ReadPart {
  int width = 0, height = 0;
  std::vector<std::pair<std::string, std::vector<float>>> channels;

  const std::vector<float>& channel(const std::string& name) const {
    for (const auto& [n, values] : channels) {
      if (n == name) return values;
    }
    throw std::runtime_error("no channel " + name);
  }
};

std::vector<ReadPart> readByOpenExr(const std::string& path) {
  Imf::MultiPartInputFile file(path.c_str());
  std::vector<ReadPart> parts;
  for (int p = 0; p < file.parts(); ++p) {
    Imf::InputPart in(file, p);
    const Imath::Box2i box = in.header().dataWindow();
    ReadPart part;
    part.width = box.max.x - box.min.x + 1;
    part.height = box.max.y - box.min.y + 1;
    Imf::FrameBuffer buffer;
    for (auto it = in.header().channels().begin(); it != in.header().channels().end(); ++it) {
      EXPECT_EQ(it.channel().type, Imf::FLOAT);
      part.channels.push_back(
          {it.name(), std::vector<float>(static_cast<std::size_t>(part.width) * part.height)});
    }
    for (auto& [name, values] : part.channels) {
      buffer.insert(name, Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(values.data()),
                                     sizeof(float), sizeof(float) * part.width));
    }
    in.setFrameBuffer(buffer);
    in.readPixels(box.min.y, box.max.y);
    parts.push_back(std::move(part));
  }
  return parts;
}

ReadPart fromTiny(const EXRHeader& header, const EXRImage& image) {
  ReadPart part;
  part.width = image.width;
  part.height = image.height;
  const std::size_t count = static_cast<std::size_t>(image.width) * image.height;
  for (int c = 0; c < image.num_channels; ++c) {
    EXPECT_EQ(header.pixel_types[c], TINYEXR_PIXELTYPE_FLOAT);
    const float* const values = reinterpret_cast<const float*>(image.images[c]);
    part.channels.push_back({header.channels[c].name, std::vector<float>(values, values + count)});
  }
  return part;
}

std::vector<ReadPart> readByTinyExr(const std::string& path) {
  EXRVersion version;
  EXPECT_EQ(ParseEXRVersionFromFile(&version, path.c_str()), TINYEXR_SUCCESS);
  const char* error = nullptr;
  std::vector<ReadPart> parts;
  if (!version.multipart) {
    EXRHeader header;
    EXRImage image;
    InitEXRHeader(&header);
    InitEXRImage(&image);
    EXPECT_EQ(ParseEXRHeaderFromFile(&header, &version, path.c_str(), &error), TINYEXR_SUCCESS);
    EXPECT_EQ(LoadEXRImageFromFile(&image, &header, path.c_str(), &error), TINYEXR_SUCCESS);
    parts.push_back(fromTiny(header, image));
    FreeEXRImage(&image);
    FreeEXRHeader(&header);
    return parts;
  }
  EXRHeader** headers = nullptr;
  int count = 0;
  EXPECT_EQ(ParseEXRMultipartHeaderFromFile(&headers, &count, &version, path.c_str(), &error),
            TINYEXR_SUCCESS);
  std::vector<EXRImage> images(count);
  for (EXRImage& image : images) InitEXRImage(&image);
  EXPECT_EQ(LoadEXRMultipartImageFromFile(images.data(), const_cast<const EXRHeader**>(headers),
                                          static_cast<unsigned>(count), path.c_str(), &error),
            TINYEXR_SUCCESS);
  for (int k = 0; k < count; ++k) {
    parts.push_back(fromTiny(*headers[k], images[k]));
    FreeEXRImage(&images[k]);
    FreeEXRHeader(headers[k]);
    std::free(headers[k]);
  }
  std::free(headers);
  return parts;
}

class Exr : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(::testing::TempDir()) /
              ("octet_exr_" +
               std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  std::size_t files() const {
    return static_cast<std::size_t>(
        std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }

  fs::path folder_;
};

/// A vector field in a ball of radius 1 around (1, 2, 3).
const Vec3 kCentre(1, 2, 3);
Vec3 flow(const Vec3& p) { return {p[0] + 2 * p[1], p[1] * p[2], 3 - p[0]}; }

Subject ball(int components) {
  Subject subject;
  subject.source = "test";
  subject.form = components == 3 ? "flow" : "smoke";
  subject.degree = components == 3 ? 2 : 0;
  subject.components = components;
  subject.bounds = {kCentre - Vec3::Ones(), kCentre + Vec3::Ones()};
  subject.detail = 0.01;
  subject.sample = [components](const Vec3& p, double* value) {
    if ((p - kCentre).norm() > 1) return false;
    const Vec3 v = flow(p);
    std::copy(v.data(), v.data() + components, value);
    return true;
  };
  return subject;
}

/// Every pixel of a slice as the header says where it lies.
void checkFlow(const ReadPart& part, const SliceGrid& grid, const std::array<std::string, 3>& names,
               int firstColumn = 0, int firstRow = 0) {
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      const std::size_t k = static_cast<std::size_t>(firstRow + y) * part.width + firstColumn + x;
      const Vec3 p = grid.point(x + 0.5, y + 0.5);
      const bool inside = (p - kCentre).norm() <= 1;
      ASSERT_EQ(part.channel("A")[k], inside ? 1.0f : 0.0f);
      for (int c = 0; c < 3; ++c) {
        ASSERT_EQ(part.channel(names[c])[k], inside ? static_cast<float>(flow(p)[c]) : 0.0f);
      }
    }
  }
}

TEST_F(Exr, SingleSliceIsReadBackByBoth) {
  for (const int axis : {0, 1, 2}) {
    SliceExrOptions options;
    options.axis = axis;
    options.position = kCentre[axis] + 0.2;
    options.width = 37;
    options.height = 23;
    writeSliceExr(ball(3), options, path("slice.exr"));
    const SliceGrid grid = fitSlice(ball(3), axis, options.position, 37, 23);
    EXPECT_EQ(grid.height, 23);
    for (const auto& parts : {readByOpenExr(path("slice.exr")), readByTinyExr(path("slice.exr"))}) {
      ASSERT_EQ(parts.size(), 1u);
      EXPECT_EQ(parts[0].channels.size(), 4u);
      checkFlow(parts[0], grid, {"velocity.X", "velocity.Y", "velocity.Z"});
    }
  }
  EXPECT_EQ(files(), 1u);
}

TEST_F(Exr, HeaderSaysWhereThePixelsLie) {
  SliceExrOptions options;
  options.axis = 1;
  options.position = 2.5;
  options.width = options.height = 20;
  options.quantity = Quantity::Divergence;
  options.spacing = 0.125;
  writeSliceExr(ball(3), options, path("slice.exr"));
  Imf::MultiPartInputFile file(path("slice.exr").c_str());
  const Imf::Header& h = file.header(0);
  const auto text = [&](const char* name) {
    return h.typedAttribute<Imf::StringAttribute>(name).value();
  };
  const auto number = [&](const char* name) {
    return h.typedAttribute<Imf::DoubleAttribute>(name).value();
  };
  EXPECT_EQ(text("octet.axis"), "y");
  EXPECT_EQ(text("octet.right"), "x");
  EXPECT_EQ(text("octet.up"), "z");
  EXPECT_EQ(text("octet.form"), "flow");
  EXPECT_EQ(text("octet.quantity"), "divergence");
  EXPECT_EQ(h.typedAttribute<Imf::IntAttribute>("octet.degree").value(), 2);
  EXPECT_EQ(number("octet.position"), 2.5);
  EXPECT_DOUBLE_EQ(number("octet.spacing"), 0.1);
  EXPECT_EQ(number("octet.differences"), 0.125);
  EXPECT_EQ(h.typedAttribute<Imf::V3dAttribute>("octet.worldMin").value(), Imath::V3d(0, 2.5, 2));
  EXPECT_EQ(h.typedAttribute<Imf::V3dAttribute>("octet.worldMax").value(), Imath::V3d(2, 2.5, 4));
  // div flow = 1 + z, differences of a quadratic field are exact.
  const ReadPart part = readByTinyExr(path("slice.exr"))[0];
  const SliceGrid grid = fitSlice(ball(3), 1, 2.5, 20, 20);
  int inside = 0;
  for (int y = 0; y < 20; ++y) {
    for (int x = 0; x < 20; ++x) {
      const std::size_t k = static_cast<std::size_t>(y) * 20 + x;
      if (part.channel("A")[k] == 0) continue;
      ++inside;
      EXPECT_NEAR(part.channel("divergence")[k], 1 + grid.point(x + 0.5, y + 0.5)[2], 1e-5);
    }
  }
  EXPECT_GT(inside, 100);
}

TEST_F(Exr, StackIsOnePartPerSlice) {
  SliceExrOptions options;
  options.stack = 4;
  options.width = options.height = 16;
  options.rgb = true;
  writeSliceExr(ball(3), options, path("stack.exr"));
  const auto ours = readByOpenExr(path("stack.exr")), theirs = readByTinyExr(path("stack.exr"));
  ASSERT_EQ(ours.size(), 4u);
  ASSERT_EQ(theirs.size(), 4u);
  Imf::MultiPartInputFile file(path("stack.exr").c_str());
  for (int k = 0; k < 4; ++k) {
    const double z = 2 + (k + 0.5) * 0.5;
    EXPECT_DOUBLE_EQ(file.header(k).typedAttribute<Imf::DoubleAttribute>("octet.position").value(),
                     z);
    EXPECT_DOUBLE_EQ(
        file.header(k).typedAttribute<Imf::DoubleAttribute>("octet.sliceSpacing").value(), 0.5);
    const SliceGrid grid = fitSlice(ball(3), 2, z, 16, 16);
    checkFlow(ours[k], grid, {"R", "G", "B"});
    checkFlow(theirs[k], grid, {"R", "G", "B"});
  }
}

TEST_F(Exr, AtlasHoldsTheSameSlices) {
  SliceExrOptions options;
  options.stack = 5;
  options.atlas = true;
  options.layer = "flow_1";
  options.width = options.height = 16;
  writeSliceExr(ball(3), options, path("atlas.exr"));
  Imf::MultiPartInputFile file(path("atlas.exr").c_str());
  const Imf::Header& h = file.header(0);
  const int columns = h.typedAttribute<Imf::IntAttribute>("octet.atlasColumns").value();
  const int rows = h.typedAttribute<Imf::IntAttribute>("octet.atlasRows").value();
  const auto positions = h.typedAttribute<Imf::FloatVectorAttribute>("octet.positions").value();
  ASSERT_EQ(positions.size(), 5u);
  for (const auto& parts : {readByOpenExr(path("atlas.exr")), readByTinyExr(path("atlas.exr"))}) {
    ASSERT_EQ(parts.size(), 1u);
    EXPECT_EQ(parts[0].width, 16 * columns);
    EXPECT_EQ(parts[0].height, 16 * rows);
    for (int k = 0; k < 5; ++k) {
      const double z = 2 + (k + 0.5) * 0.4;
      EXPECT_FLOAT_EQ(positions[k], static_cast<float>(z));
      checkFlow(parts[0], fitSlice(ball(3), 2, z, 16, 16), {"flow_1.X", "flow_1.Y", "flow_1.Z"},
                k % columns * 16, k / columns * 16);
    }
  }
}

TEST_F(Exr, ScalarsAreNamedAfterTheirForm) {
  SliceExrOptions options;
  options.width = options.height = 8;
  for (const auto& [form, channel] :
       std::vector<std::pair<std::string, std::string>>{{"smoke", "smoke"},
                                                        {"A", "Y"},
                                                        {"two words", "Y"},
                                                        {"a.b", "Y"},
                                                        {std::string(40, 'x'), "Y"}}) {
    Subject subject = ball(1);
    subject.form = form;
    writeSliceExr(subject, options, path("scalar.exr"));
    for (const auto& parts :
         {readByOpenExr(path("scalar.exr")), readByTinyExr(path("scalar.exr"))}) {
      ASSERT_EQ(parts[0].channels.size(), 2u);
      const Vec3 p = fitSlice(subject, 2, {}, 8, 8).point(3.5, 4.5);
      EXPECT_EQ(parts[0].channel(channel)[4 * 8 + 3], static_cast<float>(flow(p)[0]));
    }
  }
}

TEST_F(Exr, BadRequestsAreRefusedAndLeaveNothing) {
  const auto refused = [&](const Subject& subject, const SliceExrOptions& options) {
    EXPECT_THROW(writeSliceExr(subject, options, path("bad.exr")), InputError);
    EXPECT_EQ(files(), 0u);
  };
  SliceExrOptions options;
  options.position = 4.01;
  refused(ball(3), options);
  options.position = NAN;
  refused(ball(3), options);
  options = {};
  options.stack = 2;
  options.position = 3;
  refused(ball(3), options);
  options = {};
  options.stack = 0;
  refused(ball(3), options);
  options = {};
  options.layer = "a.b";
  refused(ball(3), options);
  options = {};
  options.quantity = Quantity::Curl;
  refused(ball(1), options);
  refused(Subject{}, {});
  EXPECT_THROW(writeSliceExr(ball(3), {}, path("missing/bad.exr")), IoError);
}

TEST_F(Exr, CancelledAndFailedFilesDoNotAppear) {
  SliceExrOptions options;
  options.stack = 3;
  options.width = options.height = 64;
  int reports = 0;
  const auto progress = [&](const ProgressReport& report) {
    EXPECT_LE(report.done, report.total);
    return ++reports < 5;
  };
  std::ofstream(path("cancelled.exr")) << "before";
  EXPECT_THROW(writeSliceExr(ball(3), options, path("cancelled.exr"), progress), Cancelled);
  EXPECT_EQ(files(), 1u);
  EXPECT_EQ(fs::file_size(path("cancelled.exr")), 6u);
  const auto failing = [](std::size_t) -> std::vector<float> { throw std::bad_alloc(); };
  EXPECT_THROW(writeExr({{"a", 4, 4, {"Y"}, {}}}, failing, path("failed.exr")), std::bad_alloc);
  EXPECT_EQ(files(), 1u);
}

}  // namespace
}  // namespace octet
