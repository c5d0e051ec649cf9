#include "io/containers/unpack.h"

#include <bzlib.h>
#include <lz4frame.h>
#include <zstd.h>

#include <memory>

namespace plumbline {
namespace {

bool unpack_bz2(std::string_view stored, std::string* bytes) {
  auto size = static_cast<unsigned>(bytes->size());
  const int status = BZ2_bzBuffToBuffDecompress(bytes->data(), &size, const_cast<char*>(stored.data()),
                                                static_cast<unsigned>(stored.size()), 0, 0);
  return status == BZ_OK && size == bytes->size();
}

bool unpack_lz4(std::string_view stored, std::string* bytes) {
  LZ4F_dctx* context = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&context, LZ4F_VERSION))) return false;
  const std::unique_ptr<LZ4F_dctx, LZ4F_errorCode_t (*)(LZ4F_dctx*)> owner(context, &LZ4F_freeDecompressionContext);
  std::size_t in = 0, out = 0;
  for (;;) {
    std::size_t taken = stored.size() - in, made = bytes->size() - out;
    const std::size_t hint = LZ4F_decompress(context, bytes->data() + out, &made, stored.data() + in, &taken, nullptr);
    if (LZ4F_isError(hint)) return false;
    in += taken;
    out += made;
    if (hint == 0) return out == bytes->size();
    if (taken == 0 && made == 0) return false;
  }
}

bool unpack_zstd(std::string_view stored, std::string* bytes) {
  return ZSTD_decompress(bytes->data(), bytes->size(), stored.data(), stored.size()) == bytes->size();
}

}  // namespace

std::optional<Packing> packing_named(std::string_view name) {
  if (name.empty() || name == "none") return Packing::none;
  if (name == "bz2") return Packing::bz2;
  if (name == "lz4") return Packing::lz4;
  if (name == "zstd") return Packing::zstd;
  return std::nullopt;
}

std::optional<std::string> unpack(Packing packing, std::string_view stored, std::size_t size) {
  std::string bytes(packing == Packing::none ? std::string(stored) : std::string(size, '\0'));
  bool good = true;
  if (packing == Packing::bz2) good = unpack_bz2(stored, &bytes);
  if (packing == Packing::lz4) good = unpack_lz4(stored, &bytes);
  if (packing == Packing::zstd) good = unpack_zstd(stored, &bytes);
  if (!good) return std::nullopt;
  return bytes;
}

bool is_zstd(std::string_view bytes) { return bytes.starts_with("\x28\xb5\x2f\xfd"); }

std::optional<std::string> unpack_zstd_frame(std::string_view stored, std::size_t limit) {
  const unsigned long long size = ZSTD_getFrameContentSize(stored.data(), stored.size());
  if (size == ZSTD_CONTENTSIZE_ERROR || (size != ZSTD_CONTENTSIZE_UNKNOWN && size > limit)) return std::nullopt;
  std::string bytes(size == ZSTD_CONTENTSIZE_UNKNOWN ? limit : static_cast<std::size_t>(size), '\0');
  const std::size_t made = ZSTD_decompress(bytes.data(), bytes.size(), stored.data(), stored.size());
  if (ZSTD_isError(made)) return std::nullopt;
  bytes.resize(made);
  return bytes;
}

}  // namespace plumbline
