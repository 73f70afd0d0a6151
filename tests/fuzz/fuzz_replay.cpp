// SPDX-License-Identifier: Apache-2.0
// The fuzz targets on known files and on a fixed number of damaged copies of them, for every
// compiler: fuzz_replay FOLDER...
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "inputs.h"

namespace fs = std::filesystem;
namespace fuzz = octet::fuzz;

namespace {

using Bytes = std::vector<std::uint8_t>;

struct Tally {
  long accepted = 0, refused = 0;
  void count(bool ok) { ++(ok ? accepted : refused); }
};

Bytes read(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

std::size_t below(std::mt19937* random, std::size_t n) {
  return (*random)() % std::max<std::size_t>(n, 1);
}

/// A copy with one to four pieces changed: bits, bytes, digits, pieces cut out, doubled or moved.
Bytes damaged(Bytes bytes, std::mt19937* random) {
  static const std::string kWords = "0123456789-+.eE,:[]{}\"\\ntf \n$";
  const std::size_t changes = 1 + below(random, 4);
  for (std::size_t k = 0; k < changes && !bytes.empty(); ++k) {
    const std::size_t at = below(random, bytes.size());
    const auto place = bytes.begin() + static_cast<std::ptrdiff_t>(at);
    const std::size_t length = 1 + below(random, std::min<std::size_t>(32, bytes.size() - at));
    const auto end = place + static_cast<std::ptrdiff_t>(length);
    switch (below(random, 6)) {
      case 0:
        *place ^= static_cast<std::uint8_t>(1u << below(random, 8));
        break;
      case 1:
        *place = static_cast<std::uint8_t>((*random)());
        break;
      case 2:
        *place = static_cast<std::uint8_t>(kWords[below(random, kWords.size())]);
        break;
      case 3:
        bytes.erase(place, end);
        break;
      case 4: {
        const Bytes piece(place, end);
        bytes.insert(place, piece.begin(), piece.end());
        break;
      }
      default: {
        const Bytes piece(place, end);
        const std::size_t to = below(random, bytes.size() - length + 1);
        std::copy(piece.begin(), piece.end(), bytes.begin() + static_cast<std::ptrdiff_t>(to));
      }
    }
  }
  return bytes;
}

/// A copy with one digit changed, which is often still a good file.
Bytes withOtherDigit(Bytes bytes, std::mt19937* random) {
  std::vector<std::size_t> digits;
  for (std::size_t k = 0; k < bytes.size(); ++k) {
    if (bytes[k] >= '0' && bytes[k] <= '9') digits.push_back(k);
  }
  if (!digits.empty()) {
    bytes[digits[below(random, digits.size())]] =
        static_cast<std::uint8_t>('0' + below(random, 10));
  }
  return bytes;
}

const char* meshExtension(const fs::path& path) {
  for (const char* extension : fuzz::kMeshExtensions) {
    if (path.extension() == extension) return extension;
  }
  return nullptr;
}

void replayAsset(const Bytes& bytes, std::mt19937* random, Tally* tally) {
  const auto test = [&](const Bytes& b) {
    const bool accepted = fuzz::tryAsset(b.data(), b.size());
    tally->count(accepted);
    return accepted;
  };
  const bool good = test(bytes);
  // A good file is cut off at every byte, and the damage goes deeper before it is noticed.
  if (good) {
    for (std::size_t n = 0; n < bytes.size(); ++n) {
      test(Bytes(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(n)));
    }
  }
  for (int k = 0; k < (good ? 1500 : 8); ++k) test(damaged(bytes, random));
  for (int k = 0; k < (good ? 500 : 0); ++k) test(withOtherDigit(bytes, random));
}

#ifdef OCTETVDB_WITH_GMSH
void replayMesh(const char* extension, const Bytes& bytes, std::mt19937* random, Tally* tally) {
  constexpr int kChecks = 1000, kReads = 12;  // reading takes a process and a tenth of a second
  for (std::size_t n = 0; n < bytes.size(); ++n) fuzz::tryMeshCheck(extension, bytes.data(), n);
  for (int k = 0; k < kChecks; ++k) {
    const Bytes b = damaged(bytes, random);
    fuzz::tryMeshCheck(extension, b.data(), b.size());
  }
  tally->count(fuzz::tryMesh(extension, bytes.data(), bytes.size()));
  for (int k = 0; k < kReads; ++k) {
    const Bytes b = damaged(bytes, random);
    tally->count(fuzz::tryMesh(extension, b.data(), b.size()));
  }
}
#endif

}  // namespace

int main(int argc, char** argv) {
  std::mt19937 random(20121231);
  Tally assets, meshes;
  for (int k = 1; k < argc; ++k) {
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(argv[k])) files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    for (const fs::path& path : files) {
      const std::string name = path.filename().string();
      if (name.find(".octet") != name.npos) replayAsset(read(path), &random, &assets);
#ifdef OCTETVDB_WITH_GMSH
      if (meshExtension(path)) replayMesh(meshExtension(path), read(path), &random, &meshes);
#endif
    }
  }
  std::printf("assets: %ld accepted, %ld refused; meshes: %ld accepted, %ld refused\n",
              assets.accepted, assets.refused, meshes.accepted, meshes.refused);
  const bool some = assets.accepted > 100 && assets.refused > 100;
  if (!some) std::fprintf(stderr, "too few inputs of one kind: was the corpus found?\n");
  return some ? EXIT_SUCCESS : EXIT_FAILURE;
}
