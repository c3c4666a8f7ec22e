// SPDX-License-Identifier: BSD-3-Clause
// The tokeniser of CLIP: byte-pair encoding of lower-case text (Radford et al.
// 2021; Sennrich et al. 2016).

#ifndef FREEGS_SEMANTICS_CLIP_BYTE_PAIR_TOKENIZER_H_
#define FREEGS_SEMANTICS_CLIP_BYTE_PAIR_TOKENIZER_H_

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "core/status.h"

namespace freegs::semantics {

struct TokenizedText {
  // The start token, the tokens of the text, and the end token; at most
  // context_length. They are not padded; CLIP pads with 0.
  std::vector<int32_t> ids;

  // True if tokens were cut off to make room for the end token.
  bool truncated = false;
};

// Tokens are numbered as in CLIP: first the 256 bytes, in the order of the
// printable characters that stand for them; then the same bytes at the end of a
// word; then the merges in the order of the file; then the start token and the
// end token.
class BytePairTokenizer {
 public:
  // Reads a file of merges, plain or compressed with gzip. kBadInput, which
  // names the file, if it is not one.
  static StatusOr<BytePairTokenizer> Load(const std::filesystem::path& path);

  // Reads merges from text. The first line is skipped. Each further line is a
  // merge of two pieces with a space between them; merges apply in the order of
  // the lines. A byte is written as the printable character that GPT-2 gave it,
  // and "</w>" ends a word. A piece must be made by an earlier line. CLIP uses
  // 48894 merges; the text after these is ignored, whatever it is.
  static StatusOr<BytePairTokenizer> Parse(std::string_view merges);

  int vocab_size() const { return end_token() + 1; }
  int start_token() const { return num_pieces_; }
  int end_token() const { return num_pieces_ + 1; }

  // text: UTF-8; bytes that are not become U+FFFD. CleanCaption() says what is
  // done to it first. context_length: the most tokens of a text, 77 for CLIP.
  // kInvalidArgument if there is no room for a token between start and end, and
  // for a text of more than 10000 bytes.
  StatusOr<TokenizedText> Tokenize(std::string_view text,
                                   int context_length) const;

 private:
  BytePairTokenizer() = default;

  // Appends the tokens of one word, given as UTF-8.
  void AppendWord(std::string_view word, std::vector<int32_t>* ids) const;

  std::array<int32_t, 256> byte_tokens_ = {};
  int num_pieces_ = 0;

  // The token that two adjacent tokens merge into. The smallest new token
  // merges first.
  std::unordered_map<uint64_t, int32_t> merges_;
};

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_CLIP_BYTE_PAIR_TOKENIZER_H_
