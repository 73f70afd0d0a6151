// SPDX-License-Identifier: Apache-2.0
// Reading documents: CBOR by RFC 8949, lines of text, values by kind, words of messages.
#include <cmath>
#include <cstdio>
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>

#include <octet/converters/control_asset/cbor_reader.h>
#include <octet/converters/control_asset/document.h>
#include <octet/converters/io/line_counter.h>

namespace octet {
namespace {

// ---- CBOR ---------------------------------------------------------------------------------------

/// Writes events down as text.
struct Recorder {
  std::string text;

  void number(double x) {
    char digits[40];
    std::snprintf(digits, sizeof digits, "%.17g ", x);
    text += digits;
  }
  void string(const std::string& s) { text += "'" + s + "' "; }
  void boolean(bool x) { text += x ? "true " : "false "; }
  void null() { text += "null "; }
  void start_object(std::size_t) { text += "{ "; }
  void key(const std::string& s) { text += s + ": "; }
  void end_object() { text += "} "; }
  void start_array(std::size_t) { text += "[ "; }
  void end_array() { text += "] "; }
};

std::string bytesOf(const std::string& hex) {
  std::string bytes;
  for (std::size_t k = 0; k + 1 < hex.size(); k += 2) {
    bytes += static_cast<char>(std::stoi(hex.substr(k, 2), nullptr, 16));
  }
  return bytes;
}

/// What is read of a document given in hexadecimal digits, or "place: reason" when it is refused.
std::string read(const std::string& hex) {
  std::istringstream in(bytesOf(hex));
  Recorder recorder;
  try {
    CborReader<Recorder>(&in, &recorder, "list of wishes").run();
  } catch (const InputError& e) {
    return e.place() + ": " + e.reason();
  }
  if (!recorder.text.empty()) recorder.text.pop_back();
  return recorder.text;
}

TEST(Cbor, NumbersOfTheStandardsAppendix) {
  EXPECT_EQ(read("00"), "0");
  EXPECT_EQ(read("17"), "23");
  EXPECT_EQ(read("1818"), "24");
  EXPECT_EQ(read("1903e8"), "1000");
  EXPECT_EQ(read("1a000f4240"), "1000000");
  EXPECT_EQ(read("1b000000e8d4a51000"), "1000000000000");
  EXPECT_EQ(read("1bffffffffffffffff"), "1.8446744073709552e+19");
  EXPECT_EQ(read("20"), "-1");
  EXPECT_EQ(read("3903e7"), "-1000");
  EXPECT_EQ(read("3bffffffffffffffff"), "-1.8446744073709552e+19");
  EXPECT_EQ(read("fb3ff199999999999a"), "1.1000000000000001");
  EXPECT_EQ(read("fa47c35000"), "100000");
  EXPECT_EQ(read("fa7f7fffff"), "3.4028234663852886e+38");
}

TEST(Cbor, HalfPrecisionNumbers) {
  EXPECT_EQ(read("f90000"), "0");
  EXPECT_EQ(read("f98000"), "-0");
  EXPECT_EQ(read("f93c00"), "1");
  EXPECT_EQ(read("f97bff"), "65504");
  EXPECT_EQ(read("f90001"), "5.9604644775390625e-08");
  EXPECT_EQ(read("f90400"), "6.103515625e-05");
  EXPECT_EQ(read("f9c400"), "-4");
  EXPECT_EQ(read("f97c00"), "inf");
  EXPECT_EQ(read("f9fc00"), "-inf");
  EXPECT_EQ(read("f97e00"), "nan");
}

TEST(Cbor, SimpleValuesAndTexts) {
  EXPECT_EQ(read("f4"), "false");
  EXPECT_EQ(read("f5"), "true");
  EXPECT_EQ(read("f6"), "null");
  EXPECT_EQ(read("60"), "''");
  EXPECT_EQ(read("6449455446"), "'IETF'");
  EXPECT_EQ(read("7f657374726561646d696e67ff"), "'streaming'");
}

TEST(Cbor, ContainersOfKnownAndOpenLength) {
  EXPECT_EQ(read("80"), "[ ]");
  EXPECT_EQ(read("8301820203820405"), "[ 1 [ 2 3 ] [ 4 5 ] ]");
  EXPECT_EQ(read("9f018202039f0405ffff"), "[ 1 [ 2 3 ] [ 4 5 ] ]");
  EXPECT_EQ(read("9fff"), "[ ]");
  EXPECT_EQ(read("a0"), "{ }");
  EXPECT_EQ(read("a26161016162820203"), "{ a: 1 b: [ 2 3 ] }");
  EXPECT_EQ(read("bf61610161629f0203ffff"), "{ a: 1 b: [ 2 3 ] }");
  EXPECT_EQ(read("d9d9f783010203"), "[ 1 2 3 ]") << "behind the tag that says that it is CBOR";
}

TEST(Cbor, RefusesWithTheNumberOfTheByte) {
  const std::string ends = "the file ends inside the document";
  EXPECT_EQ(read(""), "byte 1: " + ends);
  EXPECT_EQ(read("8201"), "byte 3: " + ends);
  EXPECT_EQ(read("1903"), "byte 3: " + ends);
  EXPECT_EQ(read("644945"), "byte 4: the file ends inside a text");
  EXPECT_EQ(read("0000"), "byte 2: the file goes on after the document's end");
  EXPECT_EQ(read("a10102"), "byte 2: a text is missing here");
  EXPECT_EQ(read("1c"), "byte 1: is no CBOR: a number or length of unknown size");
  EXPECT_EQ(read("7f01ff"), "byte 2: is no CBOR: no piece of a text");
}

TEST(Cbor, RefusesInWordsOfItsReader) {
  EXPECT_EQ(read("4101"), "byte 1: byte strings are not part of a list of wishes");
  EXPECT_EQ(read("c101"), "byte 1: tags are not part of a list of wishes");
  EXPECT_EQ(read("f7"), "byte 1: is no value that a list of wishes can have");
}

TEST(Cbor, ClaimedLengthsTakeNoMemory) {
  EXPECT_EQ(read("7b7fffffffffffffff41"), "byte 11: the file ends inside a text");
  EXPECT_EQ(read("9b7fffffffffffffff01"), "byte 11: the file ends inside the document");
}

TEST(Cbor, DeepNestingDoesNotRecurse) {
  std::string hex;
  for (int k = 0; k < 200000; ++k) hex += "81";
  EXPECT_EQ(read(hex), "byte 200001: the file ends inside the document");
}

// ---- lines --------------------------------------------------------------------------------------

TEST(LineCounter, SaysTheLineOfTheByteBeforeTheLast) {
  std::istringstream source("ab\ncd\n\ne");
  LineCounter lines(source.rdbuf());
  std::istream in(&lines);
  EXPECT_EQ(lines.line(), 1);
  std::string passed;
  const int expected[] = {1, 1, 1, 2, 2, 2, 3, 4};
  for (const int line : expected) {
    passed += static_cast<char>(in.get());
    EXPECT_EQ(lines.line(), line) << "after " << ::testing::PrintToString(passed);
  }
  EXPECT_EQ(passed, source.str());
  EXPECT_EQ(in.get(), std::char_traits<char>::eof());
  EXPECT_EQ(lines.line(), 4);
}

TEST(LineCounter, CountsAcrossItsOwnBlocks) {
  std::string text;
  for (int k = 0; k < 100000; ++k) text += std::to_string(k) + '\n';
  for (const bool asking : {true, false}) {
    std::istringstream source(text);
    LineCounter lines(source.rdbuf());
    std::istream in(&lines);
    std::string word;
    for (int k = 0; k < 100000; ++k) {
      ASSERT_TRUE(in >> word);
      ASSERT_EQ(word, std::to_string(k));
      if (asking) {
        ASSERT_EQ(lines.line(), k + 1);
      }
    }
    EXPECT_EQ(lines.line(), 100000);
  }
}

// ---- values -------------------------------------------------------------------------------------

class Document : public ::testing::Test {
 protected:
  ~Document() override { std::remove(path_.c_str()); }

  DocumentValue readText(const std::string& text, const DocumentKind& kind = {"list of wishes"}) {
    std::ofstream(path_, std::ios::binary) << text;
    return readDocument(path_, kind);
  }
  std::string refusal(const std::string& text) {
    try {
      readText(text);
    } catch (const InputError& e) {
      return e.place() + ": " + e.reason();
    }
    return "";
  }

  const std::string path_ = ::testing::TempDir() + "octet_document_test";
};

TEST_F(Document, ValuesAreOfOneKind) {
  const DocumentValue root = readText(
      R"({"nothing": null, "truth": true, "number": 2.5, "text": "a", "list": [1, 2],
          "table": [[1, 2], [], [3]], "array": ["b", 1], "empty": [], "object": {"k": 7}})");
  ASSERT_TRUE(root.as<DocumentObject>());
  EXPECT_EQ(root.size(), 9u);
  EXPECT_TRUE(root.member<std::nullptr_t>("nothing"));
  EXPECT_TRUE(*root.member<bool>("truth"));
  EXPECT_EQ(*root.member<double>("number"), 2.5);
  EXPECT_EQ(*root.member<std::string>("text"), "a");
  EXPECT_EQ(*root.member<NumberList>("list"), (NumberList{1, 2}));
  const auto* table = root.member<NumberTable>("table");
  ASSERT_TRUE(table);
  EXPECT_EQ(table->numbers, (NumberList{1, 2, 3}));
  EXPECT_EQ(table->rowEnds, (std::vector<std::size_t>{2, 2, 3}));
  EXPECT_TRUE(table->rowLines.empty()) << "not asked for";
  EXPECT_EQ(root.find("table")->size(), 3u);
  const auto* array = root.member<DocumentArray>("array");
  ASSERT_TRUE(array);
  EXPECT_EQ(*array->at(1).as<double>(), 1);
  EXPECT_TRUE(root.find("empty")->isEmptyArray());
  EXPECT_FALSE(root.find("list")->isEmptyArray());
  EXPECT_FALSE(root.find("number")->isEmptyArray());
  EXPECT_EQ(*root.find("object")->member<double>("k"), 7);
  EXPECT_FALSE(root.find("object")->find("other"));
  EXPECT_FALSE(root.find("list")->find("k")) << "no object";
  EXPECT_FALSE(root.member<double>("text"));
}

TEST_F(Document, LinesOfValuesAndRows) {
  const DocumentValue root =
      readText("{\n\"a\": 1,\n\"t\": [[1],\n\n[2]]\n}", {"list of wishes", /*rowLines=*/true});
  EXPECT_EQ(root.find("t")->line, 3);
  EXPECT_EQ(root.member<NumberTable>("t")->rowLines, (std::vector<int>{3, 5}));
}

TEST_F(Document, CborHoldsTheSameValues) {
  const DocumentValue root = readText(bytesOf("a261748281018102616c820304"));
  EXPECT_EQ(root.member<NumberTable>("t")->numbers, (NumberList{1, 2}));
  EXPECT_EQ(*root.member<NumberList>("l"), (NumberList{3, 4}));
  EXPECT_EQ(root.find("t")->line, 0) << "unknown";
}

TEST_F(Document, RefusesInWordsOfItsReader) {
  EXPECT_EQ(refusal("[1]"), ": is not a list of wishes: the document is not an object");
  EXPECT_EQ(refusal("2"), ": is not a list of wishes: the document is not an object");
  EXPECT_EQ(refusal(bytesOf("a1617441ff")),
            "byte 4: byte strings are not part of a list of wishes");
}

TEST_F(Document, ListsAndTablesTakeNothingElse) {
  const std::string reason = "is of another kind than the entries before";
  EXPECT_EQ(refusal(R"({"l": [1, "a"]})"), "l[1]: " + reason);
  EXPECT_EQ(refusal(R"({"l": [1, [2]]})"), "l[1]: " + reason);
  EXPECT_EQ(refusal(R"({"t": [[1], 2]})"), "t[1]: " + reason);
  EXPECT_EQ(refusal(R"({"t": [[1], [[2]]]})"), "t[1]: " + reason);
}

}  // namespace
}  // namespace octet
