// Any bytes as a checkpoint or the record of a shard. Nearly all inputs fail at a checksum, so the target writes the
// right ones: then the checks of names, sizes, channels and planes have to hold, and sums that are read are written
// again as the same.
#include <algorithm>
#include <cstring>

#include "display/checkpoint/banded_record.h"
#include "display/services/hash64.h"
#include "tests/fuzz/fuzz.h"

using namespace raylex;
using namespace raylex::display;

namespace {

void put(std::string& bytes, std::size_t at, std::uint64_t value) {
    std::memcpy(bytes.data() + at, &value, sizeof value);
}
std::uint64_t number_at(const std::string& bytes, std::size_t at) {
    std::uint64_t value = 0;
    std::memcpy(&value, bytes.data() + at, sizeof value);
    return value;
}

/// With the checksums that its other bytes ask for, as far as they make sections.
void set_checksums(std::string& bytes) {
    constexpr std::size_t header = 32, sum = 8;
    if (bytes.size() < header + sum) return;
    put(bytes, header - sum, hash64(std::string_view(bytes).substr(0, header - sum)));
    const std::size_t end = bytes.size() - sum;
    std::string sums;
    for (std::size_t at = header; end - at >= header;) {
        const std::uint64_t name = number_at(bytes, at), content = number_at(bytes, at + sum);
        if (name > end - at - header || content > end - at - header - name) return;
        const std::string_view all = bytes;
        put(bytes, at + 2 * sum, hash64(all.substr(at + header + name, content)));
        sums += all.substr(at + 2 * sum, sum);
        std::string head(all.substr(at, header - sum));
        put(bytes, at + 3 * sum, hash64(head.append(all.substr(at + header, name))));
        at += header + name + content;
    }
    put(bytes, end, hash64(sums));
}

void use(const FrameBuffer& band) {
    const FrameBufferLayout& layout = band.layout();
    // A header of a few bytes can claim a million rows without a page that is not zero.
    if (layout.width > 256 || layout.height > 256) return;
    std::string bytes, again;
    band.append_record(bytes);
    const auto read = FrameBuffer::from_record(bytes);
    fuzz::require(read.ok(), "what is written can be read");
    read->append_record(again);
    fuzz::require(bytes == again, "and is the same");
    for (std::size_t id = 0; id < band.channels().size(); ++id)
        static_cast<void>(band.resolve(static_cast<ChannelId>(id)));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const fuzz::AllocationMeter meter(fuzz::file_bytes);
    std::string bytes = fuzz::Bytes(data, size).rest();
    set_checksums(bytes);
    const fuzz::MemoryFile file(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
    static_cast<void>(read_record_file(file.path()));
    auto record = RecordFileReader::open(file.path());
    if (!record) {
        fuzz::require(!record.error().message.empty(), "a refusal says why");
        return 0;
    }
    const auto bands = BandedRecord::open(*std::move(record));
    if (!bands) return 0;
    const std::size_t count = std::min<std::size_t>(bands->bands().size(), 8);
    for (std::size_t i = 0; i < count; ++i)
        if (const auto band = bands->read(bands->bands()[i])) use(*band);
    return 0;
}
