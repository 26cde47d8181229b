// OpenImageIO behind a table of C functions; the module that image.c loads.
#include "image/oiio_module.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <exception>
#include <memory>
#include <new>
#include <string>
#include <vector>

using OIIO::ImageInput;
using OIIO::ImageOutput;
using OIIO::ImageSpec;
using OIIO::TypeDesc;

namespace
{

constexpr int MOST_CHANNELS = 1024;
constexpr int MOST_CHANNELS_KEPT = 4;

// The first line of `text`, without characters that a terminal would obey.
bool refuse(char *message, size_t message_size, const std::string &text)
{
    std::string line = text.substr(0, text.find('\n'));
    for (char &c : line) {
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) {
            c = '?';
        }
    }
    std::snprintf(message, message_size, "%s", line.empty() ? "it is damaged" : line.c_str());
    return false;
}

// --- Reading -------------------------------------------------------------------------------------

// The file's sizes, before any memory is taken for them; nullptr where they are in order.
const char *wrong_size(const ImageSpec &spec, int64_t max_pixels)
{
    if (spec.deep) {
        return "it is a deep image, with many samples a pixel; these can't be read";
    }
    if (spec.width <= 0 || spec.height <= 0 || spec.depth > 1) {
        return "it has no pixels, or is a volume";
    }
    if (spec.nchannels < 1 || spec.nchannels > MOST_CHANNELS) {
        return "it has no channels, or too many";
    }
    if (static_cast<int64_t>(spec.width) * spec.height > max_pixels) {
        return "it has more pixels than allowed";
    }
    if (spec.tile_width < 0 || spec.tile_height < 0 ||
        static_cast<int64_t>(spec.tile_width) * spec.tile_height >
            std::max<int64_t>(max_pixels, 1 << 20)) {
        return "its tiles are larger than allowed";
    }
    return nullptr;
}

// The channels [first, first + count) that make the picture.
void choose_channels(const ImageSpec &spec, int &first, int &count)
{
    first = 0;
    count = spec.nchannels;
    if (count <= MOST_CHANNELS_KEPT) {
        return;
    }
    auto name = [&](int i) {
        return i < spec.nchannels ? std::string(spec.channel_name(i)) : std::string();
    };
    for (int i = 0; i + 2 < spec.nchannels; ++i) {
        if (name(i) == "R" && name(i + 1) == "G" && name(i + 2) == "B") {
            first = i;
            count = name(i + 3) == "A" ? 4 : 3;
            return;
        }
    }
    count = 3;
}

// Whole numbers are sRGB-encoded unless the file says that they aren't; floats are linear.
bool is_srgb_encoded(const ImageSpec &spec, const std::string &format)
{
    std::string space = spec.get_string_attribute("oiio:ColorSpace");
    bool linear = OIIO::Strutil::iequals(space, "linear") ||
                  OIIO::Strutil::iequals(space, "scene_linear") ||
                  OIIO::Strutil::iequals(space, "lin_srgb");
    return !linear && !spec.format.is_floating_point() && format != "openexr" && format != "hdr";
}

bool read_pixels(ImageInput &input, OiioRead &read, char *message, size_t message_size)
{
    ImageSpec spec = input.spec();
    if (const char *wrong = wrong_size(spec, read.max_pixels)) {
        return refuse(message, message_size, wrong);
    }
    int first, count;
    choose_channels(spec, first, count);
    size_t pixels = static_cast<size_t>(spec.width) * static_cast<size_t>(spec.height);
    // Cleared, for a reader may leave out what a damaged file doesn't have.
    float *values =
        static_cast<float *>(read.allocate(pixels * static_cast<size_t>(count), sizeof(float)));
    if (!values) {
        return refuse(message, message_size, "there is not enough memory for it");
    }
    if (!input.read_image(0, 0, first, first + count, TypeDesc::FLOAT, values)) {
        std::string why = input.geterror();
        read.release(values);
        return refuse(message, message_size, why);
    }
    read.width = spec.width;
    read.height = spec.height;
    read.channels = count;
    read.pixels = values;
    read.srgb_encoded = is_srgb_encoded(spec, read.format);
    return true;
}

bool read_image(OiioRead *read, char *message, size_t message_size)
{
    try {
        OIIO::Filesystem::IOMemReader bytes(read->bytes, read->size);
        std::unique_ptr<ImageInput> input = ImageInput::create(read->format);
        if (!input || !input->supports("ioproxy")) {
            OIIO::geterror();
            return refuse(message, message_size,
                          std::string("this OpenImageIO can't read ") + read->format);
        }
        ImageSpec config, spec;
        config.attribute("oiio:UnassociatedAlpha", 1);
        input->set_ioproxy(&bytes);
        // Some readers want a name, though they don't open it.
        if (!input->open(std::string("image.") + read->format, spec, config)) {
            return refuse(message, message_size, input->geterror());
        }
        bool good = read_pixels(*input, *read, message, message_size);
        input->close();
        return good;
    } catch (const std::bad_alloc &) {
        return refuse(message, message_size, "there is not enough memory for it");
    } catch (const std::exception &error) {
        return refuse(message, message_size, error.what());
    } catch (...) {
        return refuse(message, message_size, "OpenImageIO failed");
    }
}

// --- Writing -------------------------------------------------------------------------------------

// A file that remembers the first write that failed: not every writer looks.
class CheckedFile : public OIIO::Filesystem::IOProxy
{
  public:
    explicit CheckedFile(const char *path)
        : IOProxy(path, Write), file_(std::fopen(path, "w+b")), code_(file_ ? 0 : errno)
    {
    }
    ~CheckedFile() override
    {
        finish();
    }
    CheckedFile(const CheckedFile &) = delete;
    CheckedFile &operator=(const CheckedFile &) = delete;

    const char *proxytype() const override
    {
        return "checked";
    }
    bool opened() const override
    {
        return file_ != nullptr;
    }
    int64_t tell() override
    {
        return m_pos;
    }
    bool seek(int64_t offset) override
    {
        m_pos = offset;
        return offset >= 0;
    }
    size_t write(const void *bytes, size_t size) override
    {
        size_t written = pwrite(bytes, size, m_pos);
        m_pos += static_cast<int64_t>(written);
        return written;
    }
    size_t read(void *bytes, size_t size) override
    {
        size_t got = pread(bytes, size, m_pos);
        m_pos += static_cast<int64_t>(got);
        return got;
    }
    size_t pwrite(const void *bytes, size_t size, int64_t offset) override
    {
        if (size == 0 || !go_to(offset, true)) {
            return 0;
        }
        size_t written = std::fwrite(bytes, 1, size, file_);
        if (written != size) {
            fail();
        }
        at_ += static_cast<int64_t>(written);
        size_ = std::max(size_, at_);
        return written;
    }
    size_t pread(void *bytes, size_t size, int64_t offset) override
    {
        if (size == 0 || !go_to(offset, false)) {
            return 0;
        }
        size_t got = std::fread(bytes, 1, size, file_);
        at_ += static_cast<int64_t>(got);
        return got;
    }
    size_t size() const override
    {
        return static_cast<size_t>(size_);
    }
    // errno of the first failure, or 0.
    int finish()
    {
        if (file_ && std::fclose(file_) != 0) {
            fail();
        }
        file_ = nullptr;
        return code_;
    }

  private:
    void fail()
    {
        if (code_ == 0) {
            code_ = errno ? errno : EIO;
        }
    }
    // stdio wants a seek between reading and writing.
    bool go_to(int64_t offset, bool writing)
    {
        if (!file_) {
            return false;
        }
        if (at_ != offset || writing != writing_) {
            errno = 0;
            if (fseeko(file_, static_cast<off_t>(offset), SEEK_SET) != 0) {
                fail();
                return false;
            }
        }
        at_ = offset;
        writing_ = writing;
        return true;
    }

    std::FILE *file_;
    int code_;
    int64_t at_ = 0, size_ = 0;
    bool writing_ = true;
};

TypeDesc sample_type(OiioSample sample)
{
    switch (sample) {
    case OIIO_UINT8:
        return TypeDesc::UINT8;
    case OIIO_UINT16:
        return TypeDesc::UINT16;
    case OIIO_HALF:
        return TypeDesc::HALF;
    default:
        return TypeDesc::FLOAT;
    }
}

void set_channels(ImageSpec &spec, const OiioWrite &write, TypeDesc type)
{
    spec.channelnames.clear();
    bool mixed = false;
    for (int l = 0; l < write.layer_count; ++l) {
        const OiioLayer &layer = write.layers[l];
        for (int c = 0; c < layer.used; ++c) {
            std::string name = layer.name;
            spec.channelnames.push_back(name.empty() ? layer.suffixes[c]
                                                     : name + "." + layer.suffixes[c]);
            bool id = layer.ids != nullptr;
            // Ids and positions are spoilt by half floats.
            spec.channelformats.push_back(id             ? TypeDesc(TypeDesc::UINT)
                                          : name.empty() ? type
                                                         : TypeDesc(TypeDesc::FLOAT));
            mixed = mixed || spec.channelformats.back() != type;
        }
    }
    if (!mixed) {
        spec.channelformats.clear();
    }
}

void set_attributes(ImageSpec &spec, const OiioWrite &write)
{
    std::string format = write.format;
    if (format != "tiff") { // there it makes a directory of Exif tags, which 2.4 writes wrongly
        spec.attribute("oiio:ColorSpace", write.linear ? "Linear" : "sRGB");
    }
    spec.attribute("oiio:UnassociatedAlpha", 1); // written as given, nothing divided
    if (format == "openexr") {
        spec.attribute("compression", "zip");
        static const float rec709[8] = {0.64f, 0.33f, 0.30f, 0.60f, 0.15f, 0.06f, 0.3127f, 0.3290f};
        spec.attribute("chromaticities", TypeDesc(TypeDesc::FLOAT, 8), rec709);
    } else if (format == "tiff") {
        spec.attribute("compression", "zip");
    } else if (format == "jpeg") {
        spec.attribute("Compression", "jpeg:95");
        spec.attribute("jpeg:subsampling", "4:4:4");
    } else if (format == "webp") {
        spec.attribute("Compression", "webp:98"); // 2.4 can't write it without loss
    }
    for (int i = 0; i < write.text_count; ++i) {
        spec.attribute(write.texts[i].name, write.texts[i].text);
    }
    // Lacking one, OpenImageIO would write the time of day, and no two files would be the same.
    if ((format == "openexr" || format == "tiff") && !spec.find_attribute("DateTime")) {
        spec.attribute("DateTime", "1970:01:01 00:00:00");
    }
}

// A value in [0, 1] as the nearest of 0 … largest; NaN as 0.
template <typename Whole> Whole quantize(float value, double largest)
{
    double scaled = static_cast<double>(value) * largest + 0.5;
    return static_cast<Whole>(!(scaled > 0) ? 0 : scaled < largest ? scaled : largest);
}

void append(std::vector<unsigned char> &row, const void *bytes, size_t size)
{
    const unsigned char *from = static_cast<const unsigned char *>(bytes);
    row.insert(row.end(), from, from + size);
}

void append_value(std::vector<unsigned char> &row, float value, OiioSample sample)
{
    if (sample == OIIO_UINT8) {
        row.push_back(quantize<unsigned char>(value, 255));
    } else if (sample == OIIO_UINT16) {
        uint16_t whole = quantize<uint16_t>(value, 65535);
        append(row, &whole, sizeof whole);
    } else if (sample == OIIO_HALF) {
        uint16_t narrow = 0;
        OIIO::convert_types(TypeDesc::FLOAT, &value, TypeDesc::HALF, &narrow, 1);
        append(row, &narrow, sizeof narrow);
    } else {
        append(row, &value, sizeof value);
    }
}

// One row of the picture in the file's own types, all layers' channels of a pixel together.
void make_row(const OiioWrite &write, int y, std::vector<unsigned char> &row)
{
    row.clear();
    for (int x = 0; x < write.width; ++x) {
        size_t at =
            static_cast<size_t>(y) * static_cast<size_t>(write.width) + static_cast<size_t>(x);
        for (int l = 0; l < write.layer_count; ++l) {
            const OiioLayer &layer = write.layers[l];
            if (layer.ids) {
                append(row, &layer.ids[at], sizeof layer.ids[at]);
                continue;
            }
            const float *values = layer.pixels + at * static_cast<size_t>(layer.channels);
            for (int c = 0; c < layer.used; ++c) {
                append_value(row, values[c], *layer.name ? OIIO_FLOAT : write.sample);
            }
        }
    }
}

bool write_rows(ImageOutput &output, const OiioWrite &write)
{
    std::vector<unsigned char> row;
    for (int y = 0; y < write.height; ++y) {
        make_row(write, y, row);
        // The stride must be given: for samples of the file's own types 2.4 takes it to be 0.
        auto stride = static_cast<OIIO::stride_t>(row.size() / static_cast<size_t>(write.width));
        if (!output.write_scanline(y, 0, TypeDesc::UNKNOWN, row.data(), stride)) {
            return false;
        }
    }
    return true;
}

bool write_file(const OiioWrite &write, char *message, size_t message_size)
{
    std::unique_ptr<ImageOutput> output = ImageOutput::create(write.format);
    if (!output || !output->supports("ioproxy")) {
        OIIO::geterror();
        return refuse(message, message_size,
                      std::string("this OpenImageIO can't write ") + write.format);
    }
    TypeDesc type = sample_type(write.sample);
    ImageSpec spec(write.width, write.height, 0, type);
    set_channels(spec, write, type);
    spec.nchannels = static_cast<int>(spec.channelnames.size());
    auto alpha = std::find(spec.channelnames.begin(), spec.channelnames.end(), "A");
    spec.alpha_channel =
        alpha == spec.channelnames.end() ? -1 : static_cast<int>(alpha - spec.channelnames.begin());
    set_attributes(spec, write);
    CheckedFile file(write.path);
    if (!file.opened()) {
        return refuse(message, message_size, std::strerror(file.finish()));
    }
    output->threads(1);
    output->set_ioproxy(&file);
    // Some writers look at the name's extension, though they don't open the file.
    bool good =
        output->open(std::string("image.") + write.extension, spec) && write_rows(*output, write);
    std::string why = good ? "" : output->geterror();
    if (!output->close() && good) {
        good = false;
        why = output->geterror();
    }
    output.reset();
    int code = file.finish();
    if (code != 0) {
        return refuse(message, message_size, std::strerror(code));
    }
    return good || refuse(message, message_size, why);
}

bool write_image(const OiioWrite *write, char *message, size_t message_size)
{
    try {
        return write_file(*write, message, message_size);
    } catch (const std::bad_alloc &) {
        return refuse(message, message_size, "there is not enough memory to write it");
    } catch (const std::exception &error) {
        return refuse(message, message_size, error.what());
    } catch (...) {
        return refuse(message, message_size, "OpenImageIO failed");
    }
}

} // namespace

extern "C" __attribute__((visibility("default")))
const OiioFunctions scn_oiio_functions = {OIIO_MODULE_VERSION, read_image, write_image};
