// What flat and deep OpenEXR writers share: the stream over an AtomicFile and the headers. The only private header of
// display/ that includes OpenEXR's.
#pragma once

#include <stdexcept>
#include <string>

#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfPixelType.h>

#include "display/output/atomic_file.h"
#include "display/output/writer/exr_layout.h"

namespace raylex::display {

/// OpenEXR's view of an AtomicFile. The first failure is thrown, later writes are swallowed: the library's destructors
/// write too, and whoever asks the file afterwards learns the reason. Until stop_recording() the bytes are also kept,
/// so that places in the header can be found again.
class HeaderRecorder : public Imf::OStream {
  public:
    explicit HeaderRecorder(AtomicFile& file) : Imf::OStream(file.target().c_str()), file_(file) {}
    void write(const char bytes[], int count) override {
        if (recording_) header_.append(bytes, static_cast<std::size_t>(count));
        check(file_.failed() || file_.write(bytes, static_cast<std::size_t>(count)));
    }
    std::uint64_t tellp() override { return file_.position(); }
    void seekp(std::uint64_t position) override { check(file_.failed() || file_.seek(position)); }
    void stop_recording() { recording_ = false; }
    /// Position in the file of a text in the header, or npos. Headers are written front to back.
    [[nodiscard]] std::size_t find(const std::string& text) const { return header_.find(text); }

  private:
    static void check(bool good) {
        if (!good) throw std::runtime_error("writing failed");
    }
    AtomicFile& file_;
    std::string header_;
    bool recording_ = true;
};

[[nodiscard]] Imf::PixelType pixel_type(StoredType type);
[[nodiscard]] std::size_t bytes_of(StoredType type);
/// How many lines are packed together.
[[nodiscard]] int lines_together(ExrCompression compression);
[[nodiscard]] Imf::Compression compression_of(ExrCompression compression);

/// Name, window, chromaticities and camera matrices; no channels, no type.
[[nodiscard]] Imf::Header base_header(const std::string& name, int width, int height,
                                      const ImageDescription& description);
/// What base_header() and string attributes say, the other way round.
void read_description(const Imf::Header& header, ImageDescription& description);
/// The header of one flat part, its channels and attributes included.
[[nodiscard]] Imf::Header make_header(const PlannedPart& part, const FrameBufferLayout& layout,
                                      const ImageDescription& description);

/// Compression is most of the work; the pool has a thread per processor and lives on for other files.
void start_encoder_threads();

}  // namespace raylex::display
