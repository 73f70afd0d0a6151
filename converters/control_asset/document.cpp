// SPDX-License-Identifier: Apache-2.0
#include "document.h"

#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include <octet/core/base/error.h>

#include "../io/atomic_file.h"

namespace octet {
namespace {

/// Deepest nesting of a control asset is 5: forms[0].frames["1"][..], forms[0].simplices[3][..].
constexpr std::size_t kDeepest = 16;

/// Builds a DocumentValue from parser events.
class Builder : public nlohmann::json_sax<nlohmann::json> {
 public:
  DocumentValue root;
  std::string error;
  std::size_t errorPosition = 0;

  bool null() override { return add({}); }
  bool boolean(bool x) override {
    DocumentValue v;
    v.kind = DocumentValue::Kind::Bool;
    v.truth = x;
    return add(std::move(v));
  }
  bool number_integer(number_integer_t x) override { return number(static_cast<double>(x)); }
  bool number_unsigned(number_unsigned_t x) override { return number(static_cast<double>(x)); }
  bool number_float(number_float_t x, const string_t&) override { return number(x); }
  bool string(string_t& text) override {
    DocumentValue v;
    v.kind = DocumentValue::Kind::String;
    v.text = std::move(text);
    return add(std::move(v));
  }
  bool binary(binary_t&) override { return fail("binary data is not part of a control asset"); }

  bool start_object(std::size_t) override { return open(DocumentValue::Kind::Object); }
  bool key(string_t& name) override {
    const auto& keys = stack_.back().keys;
    if (std::find(keys.begin(), keys.end(), name) != keys.end()) {
      return fail("key \"" + name + "\" appears twice");
    }
    stack_.back().keys.push_back(std::move(name));
    return true;
  }
  bool end_object() override { return close(); }
  bool start_array(std::size_t) override { return open(DocumentValue::Kind::Table); }
  bool end_array() override { return close(); }

  bool parse_error(std::size_t position, const std::string&,
                   const nlohmann::json::exception& e) override {
    // "[json.exception.parse_error.101] parse error at line 1, column 2: reason"
    std::string text = e.what();
    const auto bracket = text.find("] ");
    if (bracket != std::string::npos) text.erase(0, bracket + 2);
    errorPosition = position;
    error = text;
    return false;
  }

 private:
  bool fail(std::string reason) {
    if (error.empty()) error = std::move(reason);
    return false;
  }

  bool open(DocumentValue::Kind kind) {
    if (stack_.size() >= kDeepest) {
      return fail("is nested deeper than " + std::to_string(kDeepest) + " levels");
    }
    stack_.emplace_back();
    stack_.back().kind = kind;
    stack_.back().flat = kind == DocumentValue::Kind::Table;
    return true;
  }

  bool close() {
    DocumentValue v = std::move(stack_.back());
    stack_.pop_back();
    return add(std::move(v));
  }

  bool number(double x) {
    if (!stack_.empty() && stack_.back().kind == DocumentValue::Kind::Table && stack_.back().flat) {
      stack_.back().numbers.push_back(x);
      return true;
    }
    DocumentValue v;
    v.kind = DocumentValue::Kind::Number;
    v.number = x;
    return add(std::move(v));
  }

  bool add(DocumentValue v) {
    if (stack_.empty()) {
      root = std::move(v);
      return true;
    }
    DocumentValue& parent = stack_.back();
    if (parent.kind == DocumentValue::Kind::Table) {
      const bool row = v.kind == DocumentValue::Kind::Table && v.flat;
      const bool first = parent.numbers.empty() && parent.rowEnds.empty();
      if (row && (first || !parent.flat)) {
        parent.flat = false;
        parent.numbers.insert(parent.numbers.end(), v.numbers.begin(), v.numbers.end());
        parent.rowEnds.push_back(parent.numbers.size());
        return true;
      }
      if (!first) return fail("an array mixes numbers, arrays and other values");
      parent.kind = DocumentValue::Kind::Array;
      parent.flat = false;
    }
    parent.elements.push_back(std::move(v));
    return true;
  }

  std::vector<DocumentValue> stack_;
};

}  // namespace

const DocumentValue* DocumentValue::find(std::string_view key) const {
  for (std::size_t k = 0; k < keys.size(); ++k) {
    if (keys[k] == key) return &elements[k];
  }
  return nullptr;
}

std::size_t DocumentValue::size() const {
  if (kind != Kind::Table) return elements.size();
  return flat ? numbers.size() : rowEnds.size();
}

DocumentValue readDocument(const std::string& path) {
  std::error_code status;
  if (std::filesystem::is_directory(path, status)) throw InputError(path, "", "is a folder");
  std::ifstream file(path, std::ios::binary);
  if (!file) throw InputError(path, "", std::string("cannot be read: ") + std::strerror(errno));
  const int first = file.peek();
  if (first == std::ifstream::traits_type::eof()) throw InputError(path, "", "is empty");
  // A CBOR map starts with a byte of major type 5 or with the self-described tag 0xd9; JSON text
  // never does.
  const bool cbor = (first & 0xe0) == 0xa0 || first == 0xd9;
  Builder builder;
  bool parsed = false;
  try {
    parsed = nlohmann::json::sax_parse(
        file, &builder,
        cbor ? nlohmann::json::input_format_t::cbor : nlohmann::json::input_format_t::json, true,
        false);
  } catch (const std::bad_alloc&) {
    throw InputError(path, "", "does not fit into memory");
  } catch (const std::length_error&) {
    throw InputError(path, "", "claims more data than there can be");
  }
  if (!parsed) {
    const std::string place =
        cbor && builder.errorPosition ? "byte " + std::to_string(builder.errorPosition) : "";
    throw InputError(path, place,
                     builder.error.empty() ? "is neither JSON nor CBOR" : builder.error);
  }
  if (builder.root.kind != DocumentValue::Kind::Object) {
    throw InputError(path, "", "is not a control asset: the document is not an object");
  }
  return std::move(builder.root);
}

// ---- writing ------------------------------------------------------------------------------------

struct DocumentWriter::Output {
  Output(const std::string& path, Format f) : file(path), format(f) {
    stream = std::fopen(file.temporaryPath().c_str(), "wb");
    if (!stream) throw IoError(path, std::string("cannot be written: ") + std::strerror(errno));
    name = path;
  }
  ~Output() {
    if (stream) std::fclose(stream);
  }

  void put(std::string_view text) { std::fwrite(text.data(), 1, text.size(), stream); }
  void separate() {
    if (format == Format::Json && needsComma) put(",");
    needsComma = true;
  }
  void open(char bracket) {
    separate();
    put(std::string_view(&bracket, 1));
    needsComma = false;
  }
  void close(char bracket) {
    put(std::string_view(&bracket, 1));
    needsComma = true;
  }
  /// CBOR item head: major type and argument.
  void head(int major, std::uint64_t argument) {
    unsigned char bytes[9];
    int n = 1;
    const int sizes[] = {1, 2, 4, 8};
    if (argument < 24) {
      bytes[0] = static_cast<unsigned char>(major << 5 | static_cast<int>(argument));
    } else {
      int k = 0;
      while (k < 3 && argument >> (8 * sizes[k])) ++k;
      bytes[0] = static_cast<unsigned char>(major << 5 | (24 + k));
      for (int b = sizes[k]; b-- > 0;) bytes[n++] = static_cast<unsigned char>(argument >> (8 * b));
    }
    std::fwrite(bytes, 1, static_cast<std::size_t>(n), stream);
  }

  AtomicFile file;
  std::string name;
  Format format;
  std::FILE* stream = nullptr;
  bool needsComma = false;
};

DocumentWriter::Format DocumentWriter::formatFor(const std::string& path) {
  const std::string extension = std::filesystem::path(path).extension().string();
  return extension == ".octet" || extension == ".cbor" ? Format::Cbor : Format::Json;
}

DocumentWriter::DocumentWriter(const std::string& path, Format format)
    : out_(std::make_unique<Output>(path, format)) {}
DocumentWriter::~DocumentWriter() = default;

void DocumentWriter::beginObject(std::size_t members) {
  if (out_->format == Format::Cbor) return out_->head(5, members);
  out_->open('{');
}
void DocumentWriter::endObject() {
  if (out_->format == Format::Json) out_->close('}');
}
void DocumentWriter::beginArray(std::size_t elements) {
  if (out_->format == Format::Cbor) return out_->head(4, elements);
  out_->open('[');
}
void DocumentWriter::endArray() {
  if (out_->format == Format::Json) out_->close(']');
}
void DocumentWriter::key(std::string_view name) {
  if (out_->format == Format::Json) {
    // Members start on lines of their own, which keeps big files readable by tools.
    if (out_->needsComma) out_->put(",");
    out_->put("\n");
    out_->needsComma = false;
    value(name);
    out_->put(": ");
    out_->needsComma = false;
  } else {
    value(name);
  }
}
void DocumentWriter::value(double x) {
  if (out_->format == Format::Cbor) {
    std::uint64_t bits;
    std::memcpy(&bits, &x, sizeof bits);
    unsigned char bytes[9] = {0xfb};
    for (int b = 0; b < 8; ++b) bytes[1 + b] = static_cast<unsigned char>(bits >> (56 - 8 * b));
    std::fwrite(bytes, 1, sizeof bytes, out_->stream);
    return;
  }
  if (!std::isfinite(x)) throw InputError(out_->name, "", "a value to be written is not finite");
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, x).ptr;
  out_->separate();
  out_->put(std::string_view(text, static_cast<std::size_t>(end - text)));
}
void DocumentWriter::value(std::int64_t x) {
  if (out_->format == Format::Cbor) {
    return x >= 0 ? out_->head(0, static_cast<std::uint64_t>(x))
                  : out_->head(1, static_cast<std::uint64_t>(-(x + 1)));
  }
  out_->separate();
  out_->put(std::to_string(x));
}
void DocumentWriter::value(std::string_view text) {
  if (out_->format == Format::Cbor) {
    out_->head(3, text.size());
    return out_->put(text);
  }
  out_->separate();
  out_->put(nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
}

void DocumentWriter::close() {
  const bool failed = std::ferror(out_->stream) != 0;
  const bool closed = std::fclose(out_->stream) == 0;
  out_->stream = nullptr;
  if (failed || !closed) {
    throw IoError(out_->name, std::string("cannot be written: ") + std::strerror(errno));
  }
  out_->file.commit();
}

}  // namespace octet
