// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include <octet/core/base/context.h>

namespace octet {

struct DocumentValue;

using NumberList = std::vector<double>;

/// An array of arrays of numbers, its rows one after the other.
struct NumberTable {
  std::vector<double> numbers;
  std::vector<std::size_t> rowEnds;  ///< where each row ends in `numbers`
  std::vector<int> rowLines;         ///< where each row starts, when it was asked for
};

/// An array of anything else.
using DocumentArray = std::vector<DocumentValue>;

struct DocumentObject {
  std::vector<std::string> keys;
  std::vector<DocumentValue> values;
};

/// @brief A value of a JSON or CBOR document, kept compactly; an empty array is a list of numbers.
struct DocumentValue {
  using Data = std::variant<std::nullptr_t, bool, double, std::string, NumberList, NumberTable,
                            DocumentArray, DocumentObject>;

  Data data = nullptr;
  int line = 0;  ///< of JSON text where it starts, from 1; 0: unknown

  /// The value as one of the kinds; nullptr when it is of another.
  template <typename T>
  const T* as() const {
    return std::get_if<T>(&data);
  }
  /// The member of an object; nullptr when there is none, or no object.
  const DocumentValue* find(std::string_view key) const;
  /// The member of an object as one of the kinds; nullptr when there is none of it.
  template <typename T>
  const T* member(std::string_view key) const {
    const DocumentValue* value = find(key);
    return value ? value->as<T>() : nullptr;
  }
  /// Entries of an array or object; 0 for all else.
  std::size_t size() const;
  /// Is it an array without entries?
  bool isEmptyArray() const { return as<NumberList>() && size() == 0; }
};

/// What a reader expects of a document.
struct DocumentKind {
  const char* name;       ///< as messages call it: "control asset"
  bool rowLines = false;  ///< also keep the lines of rows, for files that people write
};

/// @brief Reads a JSON or CBOR document that is an object, whichever the file holds. Nesting is
/// limited, so a hostile file cannot exhaust the stack, and memory stays in proportion to the file.
/// @throws InputError (file, position, reason) when it cannot be read, is malformed or no object.
DocumentValue readDocument(const std::string& path, const DocumentKind& kind);

/// @brief Writes a document piece by piece, as JSON or as CBOR, without holding it in memory.
/// Numbers are written so that they read back to the same double.
class DocumentWriter {
 public:
  enum class Format { Json, Cbor };
  /// Cbor for names that end in .octet or .cbor.
  static Format formatFor(const std::string& path);

  /// The file appears under its name only after `close`.
  /// @param context  polled while arrays are written
  DocumentWriter(const std::string& path, Format format, const Context& context = {});
  ~DocumentWriter();

  void beginObject(std::size_t members);
  void endObject();
  void key(std::string_view name);
  void beginArray(std::size_t elements);
  void endArray();
  void value(double x);
  void value(std::int64_t x);
  void value(std::string_view text);

  /// A row of numbers as an array.
  template <typename Row>
  void row(const Row& numbers) {
    beginArray(static_cast<std::size_t>(numbers.size()));
    for (const auto x : numbers) number(x);
    endArray();
  }
  /// A key with an array of rows.
  template <typename Rows>
  void table(std::string_view name, const Rows& rows) {
    key(name);
    beginArray(rows.size());
    for (const auto& r : rows) row(r);
    endArray();
  }
  /// A key with an array of numbers.
  template <typename Row>
  void list(std::string_view name, const Row& numbers) {
    key(name);
    row(numbers);
  }

  /// @throws IoError when something could not be written.
  void close();

 private:
  void number(double x) { value(x); }
  void number(std::int32_t x) { value(static_cast<std::int64_t>(x)); }
  void number(std::int64_t x) { value(x); }

  struct Output;
  std::unique_ptr<Output> out_;
};

}  // namespace octet
