// All that the project knows of GDCM, which is C++: its decoders of JPEG, JPEG-LS and JPEG 2000. They get the
// bytes of one picture, whose size in its own header was compared with the image's before; GDCM's parser of files is
// not used. Each call has its own codec, so that slices are unpacked on several threads. No exception leaves this file.
#include "io/formats/dicom/dicom_gdcm.h"

#include <cstring>
#include <exception>
#include <gdcmDataElement.h>
#include <gdcmFragment.h>
#include <gdcmJPEG2000Codec.h>
#include <gdcmJPEGCodec.h>
#include <gdcmJPEGLSCodec.h>
#include <gdcmSequenceOfFragments.h>
#include <gdcmTag.h>
#include <gdcmTrace.h>
#include <gdcmTransferSyntax.h>

namespace {

// GDCM writes to the standard streams unless it is told not to; once, for all threads.
bool silence()
{
    gdcm::Trace::DebugOff();
    gdcm::Trace::WarningOff();
    gdcm::Trace::ErrorOff();
    return true;
}

gdcm::DataElement pixel_data(const uint8_t *in, size_t n_in)
{
    gdcm::Fragment fragment;
    fragment.SetByteValue(reinterpret_cast<const char *>(in), gdcm::VL(static_cast<uint32_t>(n_in)));
    gdcm::SmartPointer<gdcm::SequenceOfFragments> pieces = new gdcm::SequenceOfFragments;
    pieces->AddFragment(fragment);
    gdcm::DataElement element(gdcm::Tag(0x7fe0, 0x0010));
    element.SetVR(gdcm::VR::OB);
    element.SetValue(*pieces);
    return element;
}

template <class Codec>
bool unpack(vvi_gdcm_picture &p, uint8_t *out, size_t n_out, const uint8_t *in, size_t n_in, unsigned stored)
{
    Codec codec;
    const unsigned dims[3] = {p.columns, p.rows, 1};
    codec.SetDimensions(dims);
    codec.SetNumberOfDimensions(2);
    codec.SetPlanarConfiguration(0);
    codec.SetPhotometricInterpretation(
        gdcm::PhotometricInterpretation(gdcm::PhotometricInterpretation::GetPIType(p.photometric)));
    codec.SetPixelFormat(gdcm::PixelFormat(static_cast<unsigned short>(p.components),
                                           static_cast<unsigned short>(p.allocated), static_cast<unsigned short>(stored),
                                           static_cast<unsigned short>(stored - 1), p.is_signed ? 1 : 0));
    const gdcm::TransferSyntax syntax(gdcm::TransferSyntax::GetTSType(p.syntax));
    if (!codec.CanDecode(syntax))
        return false;
    gdcm::DataElement result;
    if (!codec.Decode(pixel_data(in, n_in), result))
        return false;
    const gdcm::ByteValue *bytes = result.GetByteValue();
    if (!bytes || bytes->GetLength() < n_out)
        return false;
    std::memcpy(out, bytes->GetPointer(), n_out);
    p.planar = codec.GetPlanarConfiguration() == 1;
    const gdcm::PhotometricInterpretation pi = codec.GetPhotometricInterpretation();
    p.ybr = pi == gdcm::PhotometricInterpretation::YBR_FULL || pi == gdcm::PhotometricInterpretation::YBR_FULL_422;
    return true;
}

bool unpack_any(vvi_gdcm_picture &p, uint8_t *out, size_t n_out, const uint8_t *in, size_t n_in)
{
    switch (p.codec) {
    case VVI_GDCM_JPEG:
        return unpack<gdcm::JPEGCodec>(p, out, n_out, in, n_in, p.stored);
    case VVI_GDCM_JPEG_LS:
        return unpack<gdcm::JPEGLSCodec>(p, out, n_out, in, n_in, p.stored);
    default:
        return unpack<gdcm::JPEG2000Codec>(p, out, n_out, in, n_in, p.stored);
    }
}

bool unpack_safely(vvi_gdcm_picture *picture, uint8_t *out, size_t n_out, const uint8_t *in, size_t n_in)
{
    static const bool silent = silence();
    try {
        return silent && unpack_any(*picture, out, n_out, in, n_in);
    } catch (...) {
        return false;
    }
}

} // namespace

const vvi_gdcm volvis_gdcm = {VVI_GDCM_API, unpack_safely};
