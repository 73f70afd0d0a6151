// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace octet {

/// @brief A value of a JSON or CBOR document, kept compactly: an array of numbers is one flat list,
/// and an array of such arrays a table with its rows one after the other.
struct DocumentValue {
  enum class Kind { Null, Bool, Number, String, Table, Array, Object };

  Kind kind = Kind::Null;
  bool truth = false;
  double number = 0;
  std::string text;
  std::vector<double> numbers;          ///< Table: all rows, one after the other
  std::vector<std::size_t> rowEnds;     ///< Table: where each row ends; empty for a flat list
  std::vector<DocumentValue> elements;  ///< Array, and the values of an Object
  std::vector<std::string> keys;        ///< Object
  bool flat = false;                    ///< Table: an array of numbers rather than of arrays
  int line = 0;                         ///< of JSON text where it starts, from 1; 0: unknown
  std::vector<int> rowLines;            ///< Table: where each row starts, when it was asked for

  const DocumentValue* find(std::string_view key) const;
  std::size_t size() const;
};

/// @brief Reads a JSON or CBOR document, whichever the file holds. Nesting is limited, so a hostile
/// file cannot exhaust the stack, and memory stays in proportion to the file.
/// @param rowLines  also keep the lines of rows, for files that people write
/// @throws InputError (file, position, reason) when it cannot be read or is malformed.
DocumentValue readDocument(const std::string& path, bool rowLines = false);

/// @brief Writes a document piece by piece, as JSON or as CBOR, without holding it in memory.
/// Numbers are written so that they read back to the same double.
class DocumentWriter {
 public:
  enum class Format { Json, Cbor };
  /// Cbor for names that end in .octet or .cbor.
  static Format formatFor(const std::string& path);

  /// The file appears under its name only after `close`.
  DocumentWriter(const std::string& path, Format format);
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
