#include "io/containers/matroska.h"

#include "io/stamped_lines.h"
#include "plumbline/error.h"

#ifdef PLUMBLINE_MATROSKA
#include <ebml/EbmlContexts.h>
#include <ebml/EbmlHead.h>
#include <ebml/EbmlStream.h>
#include <ebml/SafeReadIOCallback.h>
#include <ebml/StdIOCallback.h>
#include <matroska/KaxAttached.h>
#include <matroska/KaxAttachments.h>
#include <matroska/KaxBlock.h>
#include <matroska/KaxCluster.h>
#include <matroska/KaxClusterData.h>
#include <matroska/KaxContexts.h>
#include <matroska/KaxInfo.h>
#include <matroska/KaxInfoData.h>
#include <matroska/KaxSegment.h>
#include <matroska/KaxTag.h>
#include <matroska/KaxTags.h>
#include <matroska/KaxTracks.h>

#include <cstring>
#include <limits>
#include <memory>
#include <stdexcept>
#endif

namespace plumbline {

bool is_matroska(std::string_view bytes) { return bytes.starts_with("\x1A\x45\xDF\xA3"); }

#ifdef PLUMBLINE_MATROSKA
namespace {

namespace ebml = libebml;
namespace kax = libmatroska;

constexpr std::uint64_t kAnySize = std::numeric_limits<std::uint64_t>::max();
constexpr std::uint64_t kMaxHeader = std::uint64_t{64} << 20;  // bytes of one part that is read whole
constexpr const char* kMatroskaAdvice = "give a recording of an Azure Kinect (k4arecorder), or copy the file again";

/// What the library throws is of several kinds, not all of them std::exception.
template <class Call>
bool without_exception(Call&& call) {
  try {
    call();
    return true;
  } catch (const Error&) {
    throw;
  } catch (...) {
    return false;
  }
}

// An element in a place where it does not belong has its number, but is none of its kind (EbmlDummy): casts are
// checked.

template <class Element>
const Element* child_of(ebml::EbmlMaster& master) {
  return dynamic_cast<Element*>(master.FindElt(EBML_INFO(Element)));
}

template <class Element, class Visit>
void each_of(ebml::EbmlMaster& master, Visit&& visit) {
  for (ebml::EbmlElement* child : master.GetElementList())
    if (auto* element = dynamic_cast<Element*>(child)) visit(*element);
}

template <class Element>
std::string text_of(ebml::EbmlMaster& master) {
  const auto* element = child_of<Element>(master);
  if (element == nullptr) return {};
  if constexpr (std::is_base_of_v<ebml::EbmlUnicodeString, Element>) {
    return element->GetValueUTF8();
  } else {
    return std::string(*element);
  }
}

template <class Element>
std::string bytes_of(ebml::EbmlMaster& master) {
  const auto* element = child_of<Element>(master);
  if (element == nullptr || element->GetBuffer() == nullptr) return {};
  return {reinterpret_cast<const char*>(element->GetBuffer()), static_cast<std::size_t>(element->GetSize())};
}

template <class Element>
std::uint64_t number_of(ebml::EbmlMaster& master, std::uint64_t otherwise) {
  const auto* element = child_of<Element>(master);
  return element == nullptr ? otherwise : static_cast<std::uint64_t>(*element);
}

/// Whether `element`, which is not looked at, hangs somewhere below.
bool is_below(ebml::EbmlMaster& master, const ebml::EbmlElement* element) {
  for (ebml::EbmlElement* child : master.GetElementList()) {
    if (child == element) return true;
    auto* deeper = dynamic_cast<ebml::EbmlMaster*>(child);
    if (deeper != nullptr && is_below(*deeper, element)) return true;
  }
  return false;
}

/// A file that does not let itself be read for ever beyond its end: the library waits there for a byte that is not 255.
class PatientFile : public ebml::StdIOCallback {
 public:
  using StdIOCallback::StdIOCallback;

  std::uint32_t read(void* buffer, std::size_t size) override {
    constexpr int kPatience = 1000;
    const std::uint32_t got = StdIOCallback::read(buffer, size);
    empty_ = got > 0 || size == 0 ? 0 : empty_ + 1;
    if (empty_ > kPatience) throw std::runtime_error("read beyond the end");
    return got;
  }

 private:
  int empty_ = 0;
};

class Indexer {
 public:
  Indexer(const std::string& path, std::vector<std::string>* notes)
      : path_(path), notes_(notes), io_(path.c_str(), MODE_READ), stream_(io_) {
    io_.setFilePointer(0, ebml::seek_end);
    size_ = io_.getFilePointer();
    io_.setFilePointer(0);
  }

  MatroskaFile index() {
    const std::unique_ptr<ebml::EbmlElement> head(stream_.FindNextID(EBML_INFO(ebml::EbmlHead), kAnySize));
    if (head == nullptr) fail("is no Matroska file");
    io_.setFilePointer(static_cast<std::int64_t>(end_of(*head)));
    const std::unique_ptr<ebml::EbmlElement> segment(stream_.FindNextID(EBML_INFO(kax::KaxSegment), kAnySize));
    if (segment == nullptr) fail("ends before its first part");
    const bool good = without_exception(
        [&] { each_child(*segment, end_of(*segment), [&](ebml::EbmlElement& part) { add_part(part); }); });
    if (!good && !has_frames()) fail("is damaged");
    if (!good || cut_off_) add_note(notes_, "the recording ends early or is damaged; it is read up to there");
    return std::move(file_);
  }

 private:
  [[noreturn]] void fail(const char* what) const { throw Error(what, path_, kMatroskaAdvice); }

  bool has_frames() const {
    for (const MatroskaTrack& track : file_.tracks)
      if (!track.frames.empty()) return true;
    return false;
  }

  /// The file's end where the element does not know its own or claims to go on beyond.
  std::uint64_t end_of(const ebml::EbmlElement& element) const {
    return element.IsFiniteSize() ? std::min(element.GetEndPosition(), size_) : size_;
  }

  /// Visits the children of an element that ends at `end`; returns the position of the first thing that is none, or
  /// `end`.
  template <class Visit>
  std::uint64_t each_child(const ebml::EbmlElement& parent, std::uint64_t end, Visit&& visit) {
    std::uint64_t at = parent.GetElementPosition() + parent.HeadSize();
    while (at < end) {
      io_.setFilePointer(static_cast<std::int64_t>(at));
      int upper_level = 0;
      const std::unique_ptr<ebml::EbmlElement> child(
          stream_.FindNextElement(EBML_CONTEXT(&parent), upper_level, kAnySize, true));
      if (child == nullptr) {
        cut_off_ = true;
        return end;
      }
      if (upper_level > 0) return child->GetElementPosition();
      const bool whole = !child->IsFiniteSize() || child->GetEndPosition() <= end;
      if (!whole) cut_off_ = true;
      resume_ = end_of(*child);
      if (whole || EbmlId(*child) == EBML_ID(kax::KaxCluster)) visit(*child);
      if (resume_ <= at) return end;
      at = resume_;
    }
    return end;
  }

  /// An element with all below it.
  ebml::EbmlMaster& read_whole(ebml::EbmlElement& element) {
    auto* master = dynamic_cast<ebml::EbmlMaster*>(&element);
    if (master == nullptr) fail("has a header where none belongs");
    if (!element.IsFiniteSize() || element.GetSize() > kMaxHeader) fail("has a header of impossible size");
    int upper_level = 0;
    ebml::EbmlElement* found = nullptr;
    element.Read(stream_, EBML_CONTEXT(&element), upper_level, found, true);
    // What was found beyond the element is ours; what was found beyond a part of it is named here, too, and hangs
    // below.
    const std::unique_ptr<ebml::EbmlElement> beyond(is_below(*master, found) ? nullptr : found);
    return *master;
  }

  void add_part(ebml::EbmlElement& part) {
    const ebml::EbmlId id(part);
    if (id == EBML_ID(kax::KaxInfo)) {
      scale_ = number_of<kax::KaxTimecodeScale>(read_whole(part), scale_);
      if (scale_ == 0 || scale_ > 1'000'000'000) fail("has an impossible unit of time");
    } else if (id == EBML_ID(kax::KaxTracks)) {
      each_of<kax::KaxTrackEntry>(read_whole(part), [&](kax::KaxTrackEntry& track) { add_track(track); });
    } else if (id == EBML_ID(kax::KaxAttachments)) {
      each_of<kax::KaxAttached>(read_whole(part), [&](kax::KaxAttached& attached) {
        file_.attachments[text_of<kax::KaxFileName>(attached)] = bytes_of<kax::KaxFileData>(attached);
      });
    } else if (id == EBML_ID(kax::KaxTags)) {
      each_of<kax::KaxTag>(read_whole(part), [&](kax::KaxTag& tag) {
        each_of<kax::KaxTagSimple>(tag, [&](kax::KaxTagSimple& simple) {
          file_.tags[text_of<kax::KaxTagName>(simple)] = text_of<kax::KaxTagString>(simple);
        });
      });
    } else if (id == EBML_ID(kax::KaxCluster)) {
      add_cluster(part);
    }
  }

  void add_track(kax::KaxTrackEntry& entry) {
    MatroskaTrack track;
    track.number = number_of<kax::KaxTrackNumber>(entry, 0);
    track.name = text_of<kax::KaxTrackName>(entry);
    track.codec = text_of<kax::KaxCodecID>(entry);
    track.codec_private = bytes_of<kax::KaxCodecPrivate>(entry);
    if (auto* video = dynamic_cast<kax::KaxTrackVideo*>(entry.FindElt(EBML_INFO(kax::KaxTrackVideo)))) {
      constexpr std::uint64_t kLargest = 1 << 14;
      track.width = static_cast<int>(std::min(number_of<kax::KaxVideoPixelWidth>(*video, 0), kLargest));
      track.height = static_cast<int>(std::min(number_of<kax::KaxVideoPixelHeight>(*video, 0), kLargest));
    }
    file_.tracks.push_back(track);
  }

  void add_cluster(ebml::EbmlElement& cluster) {
    std::uint64_t time = 0;
    const std::uint64_t end = end_of(cluster);
    resume_ = each_child(cluster, end, [&](ebml::EbmlElement& child) {
      if (auto* stamp = dynamic_cast<kax::KaxClusterTimecode*>(&child)) {
        stamp->ReadData(io_);
        time = static_cast<std::uint64_t>(*stamp);
      } else if (auto* simple = dynamic_cast<kax::KaxSimpleBlock*>(&child)) {
        add_block(*simple, time);
      } else if (dynamic_cast<kax::KaxBlockGroup*>(&child) != nullptr) {
        const std::uint64_t after = resume_;
        each_child(child, end_of(child), [&](ebml::EbmlElement& element) {
          if (auto* block = dynamic_cast<kax::KaxBlock*>(&element)) add_block(*block, time);
        });
        resume_ = after;
      }
    });
  }

  /// 256 frames of one size: the library counts them in eight bits, for ever.
  bool is_laced_for_ever(const kax::KaxInternalBlock& block) {
    unsigned char head[6] = {};  // track number of one or two bytes, time, flags, number of frames less one
    const auto start = static_cast<std::int64_t>(block.GetElementPosition() + block.HeadSize());
    io_.setFilePointer(start);
    io_.read(head, sizeof head);
    io_.setFilePointer(start);
    const int flags = (head[0] & 0x80) != 0 ? 3 : 4;
    const bool fixed_size = (head[flags] & 0x06) == 0x04;
    return fixed_size && head[flags + 1] == 0xff;
  }

  void add_block(kax::KaxInternalBlock& block, std::uint64_t cluster_time) {
    if (is_laced_for_ever(block)) fail("has a block of impossible lacing");
    block.ReadData(io_, ebml::SCOPE_PARTIAL_DATA);  // the header alone
    MatroskaTrack* track = nullptr;
    for (MatroskaTrack& candidate : file_.tracks)
      if (candidate.number == block.TrackNum()) track = &candidate;
    if (track == nullptr) return;
    const auto ticks = static_cast<double>(cluster_time) + block.GetRelativeTimestamp();
    const double nanoseconds = ticks * static_cast<double>(scale_);
    if (!(std::abs(nanoseconds) < 4e18)) fail("has a frame at an impossible time");
    const Nanoseconds time =
        (static_cast<Nanoseconds>(cluster_time) + block.GetRelativeTimestamp()) * static_cast<Nanoseconds>(scale_);
    // The frames fill the block to its end. (The library tells their positions only after it has read them all.)
    std::uint64_t total = 0;
    for (std::size_t i = 0; i < block.NumberFrames(); ++i) {
      const std::int64_t size = block.GetFrameSize(i);
      if (size < 0 || static_cast<std::uint64_t>(size) > block.GetSize()) fail("has a frame of impossible size");
      total += static_cast<std::uint64_t>(size);
    }
    if (total > block.GetSize() || block.GetEndPosition() > size_) fail("has frames of impossible size");
    std::uint64_t at = block.GetEndPosition() - total;
    for (std::size_t i = 0; i < block.NumberFrames(); ++i) {
      const auto size = static_cast<std::uint64_t>(block.GetFrameSize(i));
      track->frames.push_back({time, at, size});
      at += size;
    }
  }

  std::string path_;
  std::vector<std::string>* notes_;
  PatientFile io_;
  ebml::EbmlStream stream_;
  std::uint64_t size_ = 0, scale_ = 1'000'000;
  std::uint64_t resume_ = 0;  ///< where the visited child ends
  bool cut_off_ = false;
  MatroskaFile file_;
};

}  // namespace

MatroskaFile index_matroska(const std::string& path, std::vector<std::string>* notes) {
  MatroskaFile file;
  if (!without_exception([&] { file = Indexer(path, notes).index(); }))
    throw Error("is damaged, or cannot be read", path, kMatroskaAdvice);
  return file;
}

#else

MatroskaFile index_matroska(const std::string& path, std::vector<std::string>*) {
  throw Error("this program was built without Matroska files", path,
              "install libmatroska-dev and libebml-dev and build it again");
}

#endif

}  // namespace plumbline
