// SPDX-License-Identifier: BSD-3-Clause
// CLIP's tokeniser: byte-pair encoding of lower-case text (Radford et al. 2021;
// Sennrich et al. 2016).

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
  // Start token, the text's tokens, end token; at most context_length. Not
  // padded: CLIP pads with 0.
  std::vector<int32_t> ids;

  // True if tokens were cut off to make room for the end token.
  bool truncated = false;
};

// Tokens are numbered as in CLIP: the 256 bytes in the order of the printable
// characters that stand for them, the same at the end of a word, the merges in
// the order of the file, the start and the end token.
class BytePairTokenizer {
 public:
  // Reads a merges file, plain or gzip. kBadInput, naming the file, if it is
  // not one.
  static StatusOr<BytePairTokenizer> Load(const std::filesystem::path& path);

  // The same from text: one line that is skipped, then one merge a line, two
  // pieces with a space between, in the order in which they apply. A byte is
  // written as the printable character GPT-2 gave it; "</w>" ends a word. A
  // piece must be made by an earlier line. What follows the 48894 merges CLIP
  // uses is dropped, also without looking at it.
  static StatusOr<BytePairTokenizer> Parse(std::string_view merges);

  int vocab_size() const { return end_token() + 1; }
  int start_token() const { return num_pieces_; }
  int end_token() const { return num_pieces_ + 1; }

  // Text is UTF-8 (bytes that are not become U+FFFD); see CleanCaption for what
  // is done to it first. kInvalidArgument if the context has no room for a
  // token between start and end, or the text is longer than 10000 bytes: a
  // caption has 77 tokens.
  StatusOr<TokenizedText> Tokenize(std::string_view text,
                                   int context_length) const;

 private:
  BytePairTokenizer() = default;

  // Appends the tokens of one word, given as UTF-8.
  void AppendWord(std::string_view word, std::vector<int32_t>* ids) const;

  std::array<int32_t, 256> byte_tokens_ = {};
  int num_pieces_ = 0;

  // The token that two adjacent ones merge into. Smaller tokens merge first.
  std::unordered_map<uint64_t, int32_t> merges_;
};

}  // namespace freegs::semantics

#endif  // FREEGS_SEMANTICS_CLIP_BYTE_PAIR_TOKENIZER_H_
