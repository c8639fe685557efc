#include "mesh/xml_reader.h"

#include <algorithm>
#include <utility>

#include "base/error.h"
#include "mesh/text_scanner.h"

namespace s3 {

namespace {

bool is_space(char c) {
  return c == ' ' || c == '\t' || c == '\n' || c == '\r';
}

void append_utf8(std::string& text, std::uint32_t code) {
  const auto byte = [&](std::uint32_t value) { text += static_cast<char>(value); };
  if (code < 0x80) {
    byte(code);
  } else if (code < 0x800) {
    byte(0xc0 | code >> 6);
    byte(0x80 | (code & 0x3f));
  } else if (code < 0x10000) {
    byte(0xe0 | code >> 12);
    byte(0x80 | (code >> 6 & 0x3f));
    byte(0x80 | (code & 0x3f));
  } else {
    byte(0xf0 | code >> 18);
    byte(0x80 | (code >> 12 & 0x3f));
    byte(0x80 | (code >> 6 & 0x3f));
    byte(0x80 | (code & 0x3f));
  }
}

// Of "#246" or "#xf6"; nothing for what is no character.
std::optional<std::uint32_t> code_point(std::string_view reference) {
  if (!reference.starts_with('#')) return std::nullopt;
  reference.remove_prefix(1);
  const bool hex = reference.starts_with('x');
  if (hex) reference.remove_prefix(1);
  std::uint32_t code = 0;
  if (reference.empty() || reference.size() > 7) return std::nullopt;
  for (const char c : lower_case(reference)) {
    const bool digit = c >= '0' && c <= '9';
    if (!digit && !(hex && c >= 'a' && c <= 'f')) return std::nullopt;
    code = code * (hex ? 16 : 10) + static_cast<std::uint32_t>(digit ? c - '0' : c - 'a' + 10);
  }
  if (code == 0 || code > 0x10ffff || (code >= 0xd800 && code < 0xe000)) return std::nullopt;
  return code;
}

}  // namespace

void XmlReader::fail(const std::string& what, const std::string& hint) const {
  const auto line =
      1 + std::count(text_.begin(), text_.begin() + static_cast<std::ptrdiff_t>(at_), '\n');
  throw Error(ErrorKind::input, Stage::mesh, "mesh.bad_file",
              std::string(file_name_) + ": line " + std::to_string(line) + ": " + what,
              hint.empty() ? "The file is damaged; export the mesh again" : hint);
}

void XmlReader::skip_spaces() {
  while (at_ < text_.size() && is_space(text_[at_])) ++at_;
}

// To the text's end where there is no `end`.
void XmlReader::skip_past(std::string_view end) {
  const std::size_t found = text_.find(end, at_);
  at_ = found == std::string_view::npos ? text_.size() : found + end.size();
}

std::string_view XmlReader::operator[](std::string_view attribute) const {
  for (const Attribute& a : attributes_)
    if (a.name == attribute) return a.value;
  return {};
}

std::string_view XmlReader::take_text() {
  const std::size_t begin = at_;
  at_ = std::min(text_.find('<', at_), text_.size());
  return text_.substr(begin, at_ - begin);
}

bool XmlReader::find_tag() {
  for (;;) {
    at_ = std::min(text_.find('<', at_), text_.size());
    if (at_ == text_.size()) return false;
    const std::string_view ahead = text_.substr(at_, 4);
    if (ahead == "<!--")
      skip_past("-->");
    else if (ahead.starts_with("<?") || ahead.starts_with("<!"))
      skip_past(">");
    else
      return true;
  }
}

void XmlReader::take_attribute() {
  const std::size_t begin = at_;
  while (at_ < text_.size() && text_[at_] != '=' && text_[at_] != '>' && !is_space(text_[at_]))
    ++at_;
  const std::string_view name = text_.substr(begin, at_ - begin);
  skip_spaces();
  if (name.empty() || at_ >= text_.size() || text_[at_] != '=') fail("expected an attribute");
  ++at_;
  skip_spaces();
  const char quote = at_ < text_.size() ? text_[at_] : '\0';
  if (quote != '"' && quote != '\'')
    fail("expected a quoted value of '" + std::string(name.substr(0, 40)) + "'");
  const std::size_t end = text_.find(quote, at_ + 1);
  if (end == std::string_view::npos) fail("a quote without its end");
  attributes_.push_back({name, text_.substr(at_ + 1, end - at_ - 1)});
  at_ = end + 1;
}

void XmlReader::close_element() {
  if (open_.empty() || open_.back() != name_)
    fail("</" + std::string(name_.substr(0, 40)) + "> closes what was not opened");
  open_.pop_back();
}

bool XmlReader::next() {
  if (!find_tag()) return false;
  ++at_;
  closes_ = at_ < text_.size() && text_[at_] == '/';
  if (closes_) ++at_;
  is_empty_ = false;
  attributes_.clear();
  const std::size_t begin = at_;
  while (at_ < text_.size() && !is_space(text_[at_]) && text_[at_] != '>' && text_[at_] != '/')
    ++at_;
  name_ = text_.substr(begin, at_ - begin);
  if (name_.empty()) fail("a tag without a name");
  for (;;) {
    skip_spaces();
    if (at_ >= text_.size()) fail("the file ends within a tag");
    if (text_[at_] == '>') break;
    if (text_[at_] == '/') {
      is_empty_ = true;
      ++at_;
    } else {
      take_attribute();
    }
  }
  ++at_;
  if (closes_)
    close_element();
  else if (!is_empty_)
    open_.push_back(name_);
  return true;
}

void XmlReader::skip_element() {
  if (is_empty_) return;
  const std::size_t depth = open_.size();
  while (next())
    if (open_.size() < depth) return;
  fail("the file ends within <" + std::string(open_.back().substr(0, 40)) + ">");
}

std::string decoded_xml(std::string_view value) {
  static constexpr std::pair<std::string_view, char> kNamed[] = {
      {"amp", '&'}, {"lt", '<'}, {"gt", '>'}, {"quot", '"'}, {"apos", '\''}};
  std::string text;
  while (!value.empty()) {
    const std::size_t begin = std::min(value.find('&'), value.size());
    text += value.substr(0, begin);
    value.remove_prefix(begin);
    if (value.empty()) break;
    const std::size_t end = value.substr(0, 12).find(';');
    const std::string_view reference =
        end == std::string_view::npos ? std::string_view() : value.substr(1, end - 1);
    const auto* named = std::find_if(std::begin(kNamed), std::end(kNamed),
                                     [&](const auto& entry) { return entry.first == reference; });
    if (named != std::end(kNamed)) {
      text += named->second;
    } else if (const std::optional<std::uint32_t> code = code_point(reference)) {
      append_utf8(text, *code);
    } else {
      text += '&';  // no reference: as it is written
      value.remove_prefix(1);
      continue;
    }
    value.remove_prefix(end + 1);
  }
  return text;
}

}  // namespace s3
