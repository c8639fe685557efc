// Tags of an XML file, one after the other: what VTU and 3MF need of XML.
#pragma once
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace s3 {

/// Walks the tags of a text; comments, declarations and the text between tags are passed over. Tags
/// must nest. Nothing is expanded, so that a file cannot grow. The text must outlive the reader.
class XmlReader {
 public:
  XmlReader(std::string_view text, std::string_view file_name)
      : text_(text), file_name_(file_name) {}

  /// Moves to the next tag. @return false at the end of the text
  /// @throws Error "mesh.bad_file" for a broken tag, or one that closes another than was opened
  bool next();

  /// The tag's name, with its prefix.
  std::string_view name() const { return name_; }
  /// It is </name>.
  bool closes() const { return closes_; }
  /// It is <name/>: there will be no closing tag.
  bool is_empty() const { return is_empty_; }
  /// An attribute as it is written; empty where there is none.
  std::string_view operator[](std::string_view attribute) const;
  struct Attribute {
    std::string_view name, value;
  };
  const std::vector<Attribute>& attributes() const { return attributes_; }

  /// The text from here to the next tag.
  std::string_view take_text();
  /// Bytes up to here.
  std::size_t position() const { return at_; }

  /// Calls `body` at every child of the element whose opening tag was read last, and moves past its
  /// closing tag. `body` must leave the child as this function or skip_element() does.
  template <class Body>
  void for_each_child(Body&& body) {
    if (is_empty_) return;
    const std::size_t depth = open_.size();
    while (next()) {
      if (open_.size() < depth) return;
      body();
    }
    fail("the file ends within <" + std::string(open_.back().substr(0, 40)) + ">");
  }
  /// Moves past the element whose opening tag was read last, and all that is in it.
  void skip_element();

  /// @throws Error "mesh.bad_file" at the current line
  [[noreturn]] void fail(const std::string& what, const std::string& hint = {}) const;

 private:
  void skip_spaces();
  void skip_past(std::string_view end);
  bool find_tag();
  void take_attribute();
  void close_element();

  std::string_view text_, file_name_;
  std::size_t at_ = 0;
  std::string_view name_;
  bool closes_ = false, is_empty_ = false;
  std::vector<Attribute> attributes_;
  std::vector<std::string_view> open_;
};

/// An attribute's value with its character references (&amp; &#246; …) replaced.
std::string decoded_xml(std::string_view value);

}  // namespace s3
