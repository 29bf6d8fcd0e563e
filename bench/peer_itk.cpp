// What bench/filters and tests compare with: filters of ITK on floats in memory.
//
//     peer_itk NAME X,Y,Z [NUMBER]... < FLOATS > FLOATS
//
// Samples are x fastest, one unit apart. Seconds by the clock and of the processor, of two threads, go to the standard
// error. `ninja -C build bench/peer_itk` makes it where Debian's libinsighttoolkit5-dev is installed.
#include <itkBilateralImageFilter.h>
#include <itkConfidenceConnectedImageFilter.h>
#include <itkImage.h>
#include <itkMultiThreaderBase.h>
#include <itkN4BiasFieldCorrectionImageFilter.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <vector>

using Volume = itk::Image<float, 3>;
using Mask = itk::Image<unsigned char, 3>;

static Volume::Pointer read(const Volume::SizeType &size)
{
    auto volume = Volume::New();
    volume->SetRegions(size);
    volume->Allocate();
    const size_t n = size[0] * size[1] * size[2];
    if (fread(volume->GetBufferPointer(), sizeof(float), n, stdin) != n)
        exit(2);
    return volume;
}

// sigma, value-sigma
static Volume::Pointer bilateral(Volume *in, const std::vector<double> &number)
{
    auto filter = itk::BilateralImageFilter<Volume, Volume>::New();
    filter->SetInput(in);
    filter->SetDomainSigma(number[0]);
    filter->SetRangeSigma(number[1]);
    filter->SetDomainMu(3);
    filter->SetNumberOfRangeGaussianSamples(4000);
    filter->Update();
    return filter->GetOutput();
}

// x, y, z of the seed, deviations, iterations, radius
static Volume::Pointer grow(Volume *in, const std::vector<double> &number)
{
    auto filter = itk::ConfidenceConnectedImageFilter<Volume, Volume>::New();
    filter->SetInput(in);
    filter->SetSeed({{(long)number[0], (long)number[1], (long)number[2]}});
    filter->SetMultiplier(number[3]);
    filter->SetNumberOfIterations((unsigned)number[4]);
    filter->SetInitialNeighborhoodRadius((unsigned)number[5]);
    filter->SetReplaceValue(1);
    filter->Update();
    return filter->GetOutput();
}

// levels, iterations, the least value that the field is found in: the values without the field
static Volume::Pointer bias(Volume *in, const std::vector<double> &number)
{
    using Filter = itk::N4BiasFieldCorrectionImageFilter<Volume, Mask, Volume>;
    auto filter = Filter::New();
    auto mask = Mask::New();
    const Volume::SizeType size = in->GetLargestPossibleRegion().GetSize();
    const auto levels = (unsigned)number[0];
    mask->SetRegions(size);
    mask->Allocate();
    for (size_t i = 0; i < size[0] * size[1] * size[2]; i++)
        mask->GetBufferPointer()[i] = in->GetBufferPointer()[i] >= (float)number[2];
    Filter::VariableSizeArrayType iterations(levels);
    iterations.Fill((unsigned)number[1]);
    filter->SetInput(in);
    filter->SetMaskImage(mask);
    filter->SetMaskLabel(1);
    filter->SetNumberOfFittingLevels(levels);
    filter->SetMaximumNumberOfIterations(iterations);
    filter->SetConvergenceThreshold(0.001);
    filter->Update();
    return filter->GetOutput();
}

int main(int argc, char **argv)
{
    static const struct {
        const char *name;
        Volume::Pointer (*run)(Volume *, const std::vector<double> &);
    } filters[] = {{"bilateral", bilateral}, {"grow", grow}, {"bias", bias}};
    Volume::SizeType size;
    std::vector<double> number;
    if (argc < 3 || sscanf(argv[2], "%lu,%lu,%lu", &size[0], &size[1], &size[2]) != 3)
        return 2;
    for (int i = 3; i < argc; i++)
        number.push_back(atof(argv[i]));
    itk::MultiThreaderBase::SetGlobalDefaultNumberOfThreads(2);
    const Volume::Pointer in = read(size);
    for (const auto &filter : filters) {
        if (strcmp(filter.name, argv[1]) != 0)
            continue;
        const auto before = std::chrono::steady_clock::now();
        const clock_t used = clock();
        const Volume::Pointer out = filter.run(in, number);
        fprintf(stderr, "%.6f %.6f\n",
                std::chrono::duration<double>(std::chrono::steady_clock::now() - before).count(),
                (double)(clock() - used) / CLOCKS_PER_SEC);
        const size_t n = size[0] * size[1] * size[2];
        return fwrite(out->GetBufferPointer(), sizeof(float), n, stdout) == n ? 0 : 1;
    }
    return 2;
}
