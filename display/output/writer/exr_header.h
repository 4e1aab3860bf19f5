// Helpers of the flat and deep OpenEXR writers: the stream over an AtomicFile, and the headers. The only private header
// of display/ that includes OpenEXR's headers.
#pragma once

#include <stdexcept>
#include <string>

#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfPixelType.h>

#include "display/output/atomic_file.h"
#include "display/output/writer/exr_layout.h"

namespace raylex::display {

/// OpenEXR's stream over an AtomicFile. It throws at the first failure and ignores later writes: the library's
/// destructors write, too, and AtomicFile keeps the reason. Until stop_recording() it also stores the bytes, so that
/// positions in the header can be found.
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
    /// Position in the file of a text in the header, or npos. Headers are written from front to back.
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
/// The number of lines that are packed together.
[[nodiscard]] int lines_together(ExrCompression compression);
[[nodiscard]] Imf::Compression compression_of(ExrCompression compression);

/// A header with name, window, chromaticities and camera matrices, but without channels and type.
[[nodiscard]] Imf::Header base_header(const std::string& name, int width, int height,
                                      const ImageDescription& description);
/// Reads what base_header() and string attributes contain.
void read_description(const Imf::Header& header, ImageDescription& description);
/// The header of one flat part with its channels and attributes.
[[nodiscard]] Imf::Header make_header(const PlannedPart& part, const FrameBufferLayout& layout,
                                      const ImageDescription& description);

/// Compression is most of the work. The pool has one thread per processor and is kept for other files.
void start_encoder_threads();

}  // namespace raylex::display
