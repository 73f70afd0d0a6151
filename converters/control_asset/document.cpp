// SPDX-License-Identifier: Apache-2.0
#include "document.h"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include <octet/core/base/error.h>

#include "../io/atomic_file.h"
#include "../io/line_counter.h"
#include "cbor_reader.h"

namespace octet {
namespace {

/// Deepest nesting of a control asset is 5: forms[0].frames["1"][..], forms[0].simplices[3][..].
constexpr std::size_t kDeepest = 16;
/// Most values beside rows of numbers, which take 88 bytes each however short they are in the file.
constexpr std::size_t kMostValues = 1000000;
/// Longest part of a malformed file that a message shows.
constexpr std::size_t kLongestExcerpt = 200;

/// A part of a malformed file, fit for a line on a terminal.
std::string excerpt(std::string text) {
  for (char& c : text) {
    if (c < ' ' || c > '~') c = '?';
  }
  if (text.size() <= kLongestExcerpt) return text;
  return text.substr(0, kLongestExcerpt) + "...";
}

/// JSON has been checked by its parser.
bool isUtf8(const std::string& text) {
  try {
    nlohmann::json(text).dump();
    return true;
  } catch (const nlohmann::json::type_error&) {
    return false;
  }
}

/// Builds a DocumentValue from parser events; throws InputError with the place in the document.
class Builder : public nlohmann::json_sax<nlohmann::json> {
 public:
  DocumentValue root;

  /// @param lines  of the text that is parsed; none for CBOR
  Builder(LineCounter* lines, const DocumentKind& kind) : lines_(lines), kind_(kind) {}

  bool null() override { return add(start(nullptr)); }
  bool boolean(bool x) override { return add(start(x)); }
  bool number_integer(number_integer_t x) override { return number(static_cast<double>(x)); }
  bool number_unsigned(number_unsigned_t x) override { return number(static_cast<double>(x)); }
  bool number_float(number_float_t x, const string_t&) override { return number(x); }
  bool number(double x) {
    NumberList* list = stack_.empty() ? nullptr : std::get_if<NumberList>(&stack_.back().data);
    if (!list) return add(start(x));
    list->push_back(x);
    return true;
  }
  bool string(string_t& text) override {
    if (!isUtf8(text)) fail("is not UTF-8");
    return add(start(std::move(text)));
  }
  bool binary(binary_t&) override {
    return fail("binary data is not part of a " + std::string(kind_.name));
  }

  bool start_object(std::size_t) override { return open(DocumentObject()); }
  bool key(string_t& name) override {
    if (!isUtf8(name)) fail("a key is not UTF-8");
    openObject().keys.push_back(std::move(name));
    return true;
  }
  bool end_object() override {
    std::vector<std::string>& names = openObject().keys;
    std::vector<std::string_view> keys(names.begin(), names.end());
    std::sort(keys.begin(), keys.end());
    const auto twice = std::adjacent_find(keys.begin(), keys.end());
    if (twice == keys.end()) return close();
    const std::string key(*twice);
    names.clear();
    return fail("key \"" + excerpt(key) + "\" appears twice");
  }
  bool start_array(std::size_t) override { return open(NumberList()); }
  bool end_array() override { return close(); }

  bool parse_error(std::size_t, const std::string&, const nlohmann::json::exception& e) override {
    // "[json.exception.parse_error.101] parse error at line 1, column 2: reason", or, of a number,
    // "[json.exception.out_of_range.406] number overflow parsing '1e999'".
    const std::string text = e.what(), intro = "parse error at ";
    const auto begin = text.find(intro), end = text.find(": ", begin);
    if (begin != std::string::npos && end != std::string::npos) {
      throw InputError(text.substr(begin + intro.size(), end - begin - intro.size()),
                       excerpt(text.substr(end + 2)));
    }
    const auto bracket = text.find("] ");
    const std::string at = lines_ ? "line " + std::to_string(lines_->line()) + ", " : "";
    throw InputError(at + place(),
                     excerpt(bracket == std::string::npos ? text : text.substr(bracket + 2)));
  }

 private:
  /// Where the parser is: "forms[0].values[3]".
  std::string place() const {
    std::string text;
    for (const DocumentValue& v : stack_) {
      if (const auto* object = v.as<DocumentObject>()) {
        if (!object->keys.empty()) text += (text.empty() ? "" : ".") + excerpt(object->keys.back());
      } else {
        text += "[" + std::to_string(v.size()) + "]";
      }
    }
    return text;
  }

  DocumentObject& openObject() { return std::get<DocumentObject>(stack_.back().data); }

  DocumentValue start(DocumentValue::Data data) const {
    return {std::move(data), lines_ ? lines_->line() : 0};
  }

  [[noreturn]] bool fail(const std::string& reason) const { throw InputError(place(), reason); }

  bool open(DocumentValue::Data data) {
    if (stack_.size() >= kDeepest) {
      fail("is nested deeper than " + std::to_string(kDeepest) + " levels");
    }
    stack_.push_back(start(std::move(data)));
    return true;
  }

  bool close() {
    DocumentValue v = std::move(stack_.back());
    stack_.pop_back();
    return add(std::move(v));
  }

  bool add(DocumentValue v) {
    if (stack_.empty()) {
      root = std::move(v);
      return true;
    }
    if (addRow(v)) return true;
    DocumentValue& parent = stack_.back();
    if (parent.isEmptyArray()) parent.data = DocumentArray();
    if (parent.as<NumberList>() || parent.as<NumberTable>()) {
      fail("is of another kind than the entries before");
    }
    if (++values_ > kMostValues) {
      fail("is more than a " + std::string(kind_.name) +
           " can hold: a million texts, objects and lists");
    }
    auto* array = std::get_if<DocumentArray>(&parent.data);
    (array ? *array : openObject().values).push_back(std::move(v));
    return true;
  }

  /// Adds a list of numbers to an array that has nothing but such lists.
  bool addRow(const DocumentValue& v) {
    const auto* row = v.as<NumberList>();
    DocumentValue& parent = stack_.back();
    if (row && parent.isEmptyArray()) parent.data = NumberTable();
    auto* table = std::get_if<NumberTable>(&parent.data);
    if (!row || !table) return false;
    table->numbers.insert(table->numbers.end(), row->begin(), row->end());
    table->rowEnds.push_back(table->numbers.size());
    if (kind_.rowLines) table->rowLines.push_back(v.line);
    return true;
  }

  LineCounter* lines_;
  const DocumentKind& kind_;
  std::vector<DocumentValue> stack_;
  std::size_t values_ = 0;
};

enum class Encoding { Json, Cbor };

/// A CBOR document that can be an asset starts with the major type of maps or arrays or with the
/// self-described tag; JSON text with ASCII or a byte order mark.
Encoding encodingOf(int firstByte, const std::string& path) {
  if (firstByte < 0x80 || firstByte == 0xef) return Encoding::Json;
  if (firstByte < 0xc0 || firstByte == 0xd9) return Encoding::Cbor;
  throw InputError(path, "", "is neither JSON nor CBOR");
}

DocumentValue parse(std::istream* in, Encoding encoding, const DocumentKind& kind) {
  if (encoding == Encoding::Cbor) {
    Builder builder(nullptr, kind);
    CborReader<Builder>(in, &builder, kind.name).run();
    return std::move(builder.root);
  }
  LineCounter lines(in->rdbuf());
  std::istream text(&lines);
  Builder builder(&lines, kind);
  nlohmann::json::sax_parse(text, &builder);
  // The parser takes a zero byte for the end.
  text.clear();
  if (text.peek() != std::char_traits<char>::eof()) {
    throw InputError("", "the file goes on after the document's end");
  }
  return std::move(builder.root);
}

}  // namespace

const DocumentValue* DocumentValue::find(std::string_view key) const {
  const auto* object = as<DocumentObject>();
  for (std::size_t k = 0; object && k < object->keys.size(); ++k) {
    if (object->keys[k] == key) return &object->values[k];
  }
  return nullptr;
}

std::size_t DocumentValue::size() const {
  if (const auto* list = as<NumberList>()) return list->size();
  if (const auto* table = as<NumberTable>()) return table->rowEnds.size();
  if (const auto* array = as<DocumentArray>()) return array->size();
  if (const auto* object = as<DocumentObject>()) return object->values.size();
  return 0;
}

DocumentValue readDocument(const std::string& path, const DocumentKind& kind) {
  std::error_code status;
  if (std::filesystem::is_directory(path, status)) throw InputError(path, "", "is a folder");
  std::ifstream file(path, std::ios::binary);
  if (!file) throw InputError(path, "", std::string("cannot be read: ") + std::strerror(errno));
  const int first = file.peek();
  if (first == std::ifstream::traits_type::eof()) throw InputError(path, "", "is empty");
  const Encoding encoding = encodingOf(first, path);
  DocumentValue root;
  try {
    root = parse(&file, encoding, kind);
  } catch (const InputError& e) {
    throw e.inFile(path);
  } catch (const std::bad_alloc&) {
    throw InputError(path, "", "does not fit into memory");
  } catch (const std::length_error&) {
    throw InputError(path, "", "does not fit into memory");
  }
  if (!root.as<DocumentObject>()) {
    throw InputError(path, "",
                     "is not a " + std::string(kind.name) + ": the document is not an object");
  }
  return root;
}

// ---- writing ------------------------------------------------------------------------------------

struct DocumentWriter::Output {
  Output(const std::string& path, Format f, const Context& c) : context(c), file(path), format(f) {
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

  void poll() {
    constexpr std::size_t kArraysPerPoll = 1024;
    if (++arrays % kArraysPerPoll == 0) context.poll();
  }

  const Context context;  // of the call that made the writer
  AtomicFile file;
  std::string name;
  Format format;
  std::FILE* stream = nullptr;
  std::size_t arrays = 0;
  bool needsComma = false;
};

DocumentWriter::Format DocumentWriter::formatFor(const std::string& path) {
  const std::string extension = std::filesystem::path(path).extension().string();
  return extension == ".octet" || extension == ".cbor" ? Format::Cbor : Format::Json;
}

DocumentWriter::DocumentWriter(const std::string& path, Format format, const Context& context)
    : out_(std::make_unique<Output>(path, format, context)) {}
DocumentWriter::~DocumentWriter() = default;

void DocumentWriter::beginObject(std::size_t members) {
  if (out_->format == Format::Cbor) return out_->head(5, members);
  out_->open('{');
}
void DocumentWriter::endObject() {
  if (out_->format == Format::Json) out_->close('}');
}
void DocumentWriter::beginArray(std::size_t elements) {
  out_->poll();
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
