// SPDX-License-Identifier: BSD-3-Clause

#include "semantics/clip/byte_pair_tokenizer.h"

#include <algorithm>
#include <array>

#include "core/io/files.h"
#include "core/io/gzip.h"
#include "semantics/clip/caption_text.h"
#include "semantics/clip/unicode_text.h"

namespace freegs::semantics {
namespace {

constexpr int kNumBytes = 256;
constexpr int kMaxMerges = 49152 - kNumBytes - 2;
constexpr uint64_t kMaxVocabularyBytes = 64 << 20;
constexpr size_t kMaxTextBytes = 10000;
constexpr std::string_view kEndOfWord = "</w>";

// Bytes that are printable in Latin-1 stand for themselves and come first.
bool IsPrintableByte(int byte) {
  return (byte >= '!' && byte <= '~') ||
         (byte >= 0xA1 && byte <= 0xFF && byte != 0xAD);
}

// token[byte]: where the byte stands in the vocabulary. character[token]: how
// it is written in the merges file.
struct ByteAlphabet {
  std::array<int32_t, kNumBytes> token = {};
  std::array<char32_t, kNumBytes> character = {};
};

ByteAlphabet MakeByteAlphabet() {
  ByteAlphabet alphabet;
  int next = 0;
  for (const bool printable : {true, false}) {
    char32_t next_character = kNumBytes;
    for (int byte = 0; byte < kNumBytes; ++byte) {
      if (IsPrintableByte(byte) != printable) continue;
      alphabet.token[byte] = next;
      alphabet.character[next] =
          printable ? static_cast<char32_t>(byte) : next_character++;
      ++next;
    }
  }
  return alphabet;
}

uint64_t PairKey(int32_t left, int32_t right) {
  return static_cast<uint64_t>(static_cast<uint32_t>(left)) << 32 |
         static_cast<uint32_t>(right);
}

std::string_view NextLine(std::string_view* text) {
  const size_t end = std::min(text->find('\n'), text->size());
  std::string_view line = text->substr(0, end);
  text->remove_prefix(std::min(end + 1, text->size()));
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  return line;
}

}  // namespace

StatusOr<BytePairTokenizer> BytePairTokenizer::Load(
    const std::filesystem::path& path) {
  FREEGS_ASSIGN_OR_RETURN(std::string content,
                          ReadFile(path, kMaxVocabularyBytes));
  if (IsGzip(content)) {
    StatusOr<std::string> unpacked = Gunzip(content, kMaxVocabularyBytes);
    if (!unpacked.ok()) return unpacked.status().Annotated(path.string());
    content = *std::move(unpacked);
  }
  StatusOr<BytePairTokenizer> tokenizer = Parse(content);
  if (!tokenizer.ok()) return tokenizer.status().Annotated(path.string());
  return tokenizer;
}

StatusOr<BytePairTokenizer> BytePairTokenizer::Parse(std::string_view text) {
  // Pieces are needed while reading only; later, tokens are numbers.
  std::unordered_map<std::string, int32_t> tokens;
  const ByteAlphabet alphabet = MakeByteAlphabet();
  for (int32_t i = 0; i < kNumBytes; ++i) {
    const std::string piece = EncodeUtf8({&alphabet.character[i], 1});
    tokens[piece] = i;
    tokens[piece + std::string(kEndOfWord)] = kNumBytes + i;
  }

  BytePairTokenizer tokenizer;
  tokenizer.byte_tokens_ = alphabet.token;
  tokenizer.num_pieces_ = 2 * kNumBytes;
  NextLine(&text);
  for (int line_number = 2; !text.empty(); ++line_number) {
    if (tokenizer.num_pieces_ - 2 * kNumBytes == kMaxMerges) break;
    const std::string_view line = NextLine(&text);
    if (line.empty() && text.empty()) break;
    const auto fault = [line_number](const std::string& what) {
      return BadInputError("line " + std::to_string(line_number) + " " + what +
                           "; this is not a list of byte-pair merges");
    };
    const size_t space = line.find(' ');
    if (space == std::string_view::npos ||
        line.find(' ', space + 1) != std::string_view::npos) {
      return fault("is not two pieces with a space between");
    }
    const std::string left(line.substr(0, space));
    const std::string right(line.substr(space + 1));
    const auto left_token = tokens.find(left);
    const auto right_token = tokens.find(right);
    if (left_token == tokens.end() || right_token == tokens.end()) {
      return fault("merges a piece that no earlier line made");
    }
    if (left.ends_with(kEndOfWord)) {
      return fault("merges something behind the end of a word");
    }
    const uint64_t key = PairKey(left_token->second, right_token->second);
    if (!tokens.emplace(left + right, tokenizer.num_pieces_).second) {
      return fault("makes a piece that an earlier line made");
    }
    tokenizer.merges_[key] = tokenizer.num_pieces_++;
  }
  if (tokenizer.merges_.empty()) {
    return BadInputError("there are no byte-pair merges in it");
  }
  return tokenizer;
}

void BytePairTokenizer::AppendWord(std::string_view word,
                                   std::vector<int32_t>* ids) const {
  std::vector<int32_t> pieces;
  pieces.reserve(word.size());
  for (const char c : word) {
    pieces.push_back(byte_tokens_[static_cast<uint8_t>(c)]);
  }
  pieces.back() += kNumBytes;

  while (pieces.size() > 1) {
    int32_t best = num_pieces_;
    uint64_t best_pair = 0;
    for (size_t i = 0; i + 1 < pieces.size(); ++i) {
      const uint64_t pair = PairKey(pieces[i], pieces[i + 1]);
      const auto found = merges_.find(pair);
      if (found != merges_.end() && found->second < best) {
        best = found->second;
        best_pair = pair;
      }
    }
    if (best == num_pieces_) break;
    size_t out = 0;
    for (size_t i = 0; i < pieces.size(); ++i) {
      const bool merges = i + 1 < pieces.size() &&
                          PairKey(pieces[i], pieces[i + 1]) == best_pair;
      pieces[out++] = merges ? best : pieces[i];
      if (merges) ++i;
    }
    pieces.resize(out);
  }
  ids->insert(ids->end(), pieces.begin(), pieces.end());
}

StatusOr<TokenizedText> BytePairTokenizer::Tokenize(std::string_view text,
                                                    int context_length) const {
  if (context_length < 3) {
    return InvalidArgumentError(
        "a context of " + std::to_string(context_length) +
        " tokens has no room for text between its start and end");
  }
  if (text.size() > kMaxTextBytes) {
    return InvalidArgumentError("the text is longer than " +
                                std::to_string(kMaxTextBytes) + " bytes");
  }
  const std::u32string caption = CleanCaption(DecodeUtf8(text));
  TokenizedText result;
  result.ids.push_back(start_token());
  const auto limit = static_cast<size_t>(context_length);
  for (const std::u32string_view word : SplitCaption(caption)) {
    // Words that do not fit are not encoded.
    if (result.ids.size() >= limit) break;
    if (word == kStartOfText) {
      result.ids.push_back(start_token());
    } else if (word == kEndOfText) {
      result.ids.push_back(end_token());
    } else {
      AppendWord(EncodeUtf8(word), &result.ids);
    }
  }
  result.truncated = result.ids.size() >= limit;
  if (result.truncated) result.ids.resize(limit - 1);
  result.ids.push_back(end_token());
  return result;
}

}  // namespace freegs::semantics
