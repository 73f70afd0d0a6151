// SPDX-License-Identifier: Apache-2.0
#include "exr_file.h"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <memory>

#include <OpenEXR/Iex.h>
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfDoubleAttribute.h>
#include <OpenEXR/ImfFloatVectorAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfIntAttribute.h>
#include <OpenEXR/ImfMultiPartOutputFile.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfOutputPart.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <OpenEXR/ImfVecAttribute.h>

#include <octet/core/base/error.h>
#include <octet/version.h>

#include "../io/atomic_file.h"

namespace octet {
namespace {

/// A stream of our own, so that a full disk is noticed on closing too.
class Stream : public Imf::OStream {
 public:
  explicit Stream(const std::string& path)
      : Imf::OStream(path.c_str()), file_(path, std::ios::binary | std::ios::trunc) {}

  void write(const char bytes[], int count) override {
    if (!file_.write(bytes, count)) throw Iex::IoExc("write failed");
  }
  std::uint64_t tellp() override { return static_cast<std::uint64_t>(file_.tellp()); }
  void seekp(std::uint64_t position) override {
    file_.seekp(static_cast<std::streamoff>(position));
  }
  /// Whether all that was written has reached the system.
  bool close() {
    file_.close();
    return !file_.fail();
  }

 private:
  std::ofstream file_;
};

struct AddAttribute {
  Imf::Header* header;
  const std::string& name;

  void operator()(const std::string& v) const { header->insert(name, Imf::StringAttribute(v)); }
  void operator()(int v) const { header->insert(name, Imf::IntAttribute(v)); }
  void operator()(double v) const { header->insert(name, Imf::DoubleAttribute(v)); }
  void operator()(const Vec3& v) const {
    header->insert(name, Imf::V3dAttribute(Imath::V3d(v[0], v[1], v[2])));
  }
  void operator()(const std::vector<float>& v) const {
    header->insert(name, Imf::FloatVectorAttribute(v));
  }
};

Imf::Header makeHeader(const ExrPart& part) {
  Imf::Header header(part.width, part.height);
  header.compression() = Imf::ZIP_COMPRESSION;
  header.setName(part.name);
  header.setType(Imf::SCANLINEIMAGE);
  for (const std::string& channel : part.channels) {
    header.channels().insert(channel, Imf::Channel(Imf::FLOAT));
  }
  header.insert("software", Imf::StringAttribute(std::string("OctetVDB ") + kVersion));
  for (const ExrAttribute& a : part.attributes) std::visit(AddAttribute{&header, a.name}, a.value);
  return header;
}

Imf::FrameBuffer frameBuffer(const ExrPart& part, const std::vector<float>& pixels) {
  Imf::FrameBuffer buffer;
  const std::size_t stride = sizeof(float) * part.channels.size();
  for (std::size_t c = 0; c < part.channels.size(); ++c) {
    // The library only reads.
    char* const base = reinterpret_cast<char*>(const_cast<float*>(pixels.data() + c));
    buffer.insert(part.channels[c], Imf::Slice(Imf::FLOAT, base, stride,
                                               stride * static_cast<std::size_t>(part.width)));
  }
  return buffer;
}

void writeParts(const std::vector<ExrPart>& parts, const ExrPixels& pixels, Stream* stream) {
  std::vector<Imf::Header> headers;
  for (const ExrPart& part : parts) headers.push_back(makeHeader(part));
  // No threads of the library's own: it compresses on the calling one.
  if (parts.size() == 1) {
    const std::vector<float> values = pixels(0);
    Imf::OutputFile file(*stream, headers[0], 0);
    file.setFrameBuffer(frameBuffer(parts[0], values));
    file.writePixels(parts[0].height);
    return;
  }
  Imf::MultiPartOutputFile file(*stream, headers.data(), static_cast<int>(headers.size()), false,
                                0);
  for (std::size_t k = 0; k < parts.size(); ++k) {
    const std::vector<float> values = pixels(k);
    Imf::OutputPart output(file, static_cast<int>(k));
    output.setFrameBuffer(frameBuffer(parts[k], values));
    output.writePixels(parts[k].height);
  }
}

}  // namespace

void writeExr(const std::vector<ExrPart>& parts, const ExrPixels& pixels, const std::string& path) {
  AtomicFile file(path);
  errno = 0;
  Stream stream(file.temporaryPath());
  try {
    writeParts(parts, pixels, &stream);
  } catch (const Iex::BaseExc& e) {
    throw IoError(path,
                  std::string("cannot be written: ") + (errno ? std::strerror(errno) : e.what()));
  }
  if (!stream.close()) {
    throw IoError(path, std::string("cannot be written: ") +
                            (errno ? std::strerror(errno) : "the disk may be full"));
  }
  file.commit();
}

}  // namespace octet
