#include "display/drivers/exr_driver.h"

#include <utility>

#include "display/output/atomic_file.h"

namespace raylex::display {

namespace {

class ExrDriver : public DisplayDriver {
  public:
    explicit ExrDriver(std::string file) : file_(std::move(file)) {}
    Status open(const DriverImage& image) override {
        if (Status layout = check_exr_layout(image.channels, image.beauty, image.partitions); !layout) return layout;
        return check_writable(file_);
    }
    Status close(const FinishedImage& image) override {
        return write_exr(file_, image.frame_buffer, image.beauty, image.description);
    }
    [[nodiscard]] std::string file() const override { return file_; }

  private:
    std::string file_;
};

}  // namespace

Registry<DisplayDriverFactory>::Entry exr_driver_entry() {
    return {"exr",
            "one multi-part OpenEXR file with every layer",
            {{"file", ParameterType::string, "", "the file's name"}},
            [](const ParameterSet& parameters, const DriverContext&) -> Result<std::unique_ptr<DisplayDriver>> {
                auto file = parameters.string_or("file", "");
                if (!file) return file.error();
                if (file->empty())
                    return error_at(parameters.location, "display driver 'exr' has no file; expected file=NAME.exr");
                return std::unique_ptr<DisplayDriver>(std::make_unique<ExrDriver>(*file));
            }};
}

}  // namespace raylex::display
