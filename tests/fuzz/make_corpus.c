/* Writes the seeds of all fuzz targets: the smallest file of each dialect, made by our own writers, and texts.
 *   make_corpus FOLDER */
#include "config.h"
#include "dicoms.h"
#include "fields.h"
#include "meshes.h"
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <volvis/sys/registry.h>
#include <volvis/volvis.h>

static const char *root;

static void stop(const char *what)
{
    fprintf(stderr, "make_corpus: %s: %s\n", what, vv_error_last()->message);
    exit(1);
}

static const char *path_of(const char *target, const char *name)
{
    static char path[4096];
    snprintf(path, sizeof path, "%s/%s", root, target);
    if (mkdir(path, 0755) != 0 && errno != EEXIST)
        stop(path);
    snprintf(path, sizeof path, "%s/%s/%s", root, target, name);
    return path;
}

static void put(const char *target, const char *name, const void *data, size_t n)
{
    FILE *file = fopen(path_of(target, name), "wb");
    if (!file || fwrite(data, 1, n, file) != n || fclose(file) != 0)
        stop(name);
}

static void put_text(const char *target, const char *name, const char *text)
{
    put(target, name, text, strlen(text));
}

static vv_field_info seed_info(vv_type type, int components, vv_meaning meaning)
{
    vv_field_info info = vv_field_info_default();
    info.grid.dims[0] = 3;
    info.grid.dims[1] = 2;
    info.grid.dims[2] = 2;
    info.grid.index_to_world.axis[1].y = -1.5;
    info.grid.space = VV_SPACE_RAS;
    strcpy(info.grid.unit, "mm");
    info.type = type;
    info.components = components;
    info.meaning = meaning;
    info.frame_step = 2;
    strcpy(info.frame_unit, "s");
    strcpy(info.name, "seed");
    return info;
}

static void write_volume(const char *target, const char *name, const char *encoding, const vv_field_info *info,
                         int n_frames, bool big_endian)
{
    static const vv_label labels[] = {{1, "one & \\", true, {0.5, 0.25, 1, 0.5}}, {3, "three", false, {0}}};
    vv_field *frame[2] = {test_field_random(info, 1, NULL), test_field_random(info, 2, NULL)};
    vv_write_options options;
    vv_write_options_init(&options, sizeof options);
    options.encoding = encoding;
    options.big_endian = big_endian;
    if (info->meaning == VV_MEANING_LABEL) {
        options.labels = labels;
        options.n_labels = sizeof labels / sizeof *labels;
    }
    if (vv_field_write(path_of(target, name), (const vv_field *const *)frame, (size_t)n_frames, &options, NULL) !=
        VV_OK)
        stop(name);
    vv_field_release(frame[0]);
    vv_field_release(frame[1]);
}

static void write_volumes(void)
{
    static const char *const encodings[] = {"raw", "ascii", "hex", "gzip", "bzip2"};
    char name[64];
    for (int type = 0; type < VV_TYPE_COUNT; type++) {
        const vv_field_info info = seed_info((vv_type)type, 1, VV_MEANING_SCALAR);
        snprintf(name, sizeof name, "%s-%s.nrrd", encodings[type % 5], vv_type_name((vv_type)type));
        write_volume("nrrd", name, encodings[type % 5], &info, 1 + type % 2, type % 3 == 0);
        snprintf(name, sizeof name, "%s.nii", vv_type_name((vv_type)type));
        write_volume("nifti", name, NULL, &info, 1 + type % 2, type % 3 == 0);
        snprintf(name, sizeof name, "%s.mha", vv_type_name((vv_type)type));
        write_volume("metaimage", name, type % 2 ? "zlib" : "raw", &info, 1 + type % 2, type % 3 == 0);
        static const char *const tiff_encodings[] = {"raw", "deflate", "lzw"};
        snprintf(name, sizeof name, "%s-%s.tif", tiff_encodings[type % 3], vv_type_name((vv_type)type));
        write_volume("tiff", name, tiff_encodings[type % 3], &info, 1 + type % 2, type % 3 == 0);
        snprintf(name, sizeof name, "%s.mrc", vv_type_name((vv_type)type));
        if (type < VV_TYPE_U32 || type >= VV_TYPE_F32)
            write_volume("mrc", name, NULL, &info, 1 + type % 2, type % 3 == 0);
        static const char *const forms[] = {"raw", "zlib", "base64", "ascii"};
        snprintf(name, sizeof name, "%s-%s.vti", forms[type % 4], vv_type_name((vv_type)type));
        write_volume("vti", name, forms[type % 4], &info, 1, type % 3 == 0);
        snprintf(name, sizeof name, "%s.npy", vv_type_name((vv_type)type));
        write_volume("npy", name, NULL, &info, 1 + type % 2, type % 3 == 0);
    }
    const vv_field_info rgb = seed_info(VV_TYPE_U8, 3, VV_MEANING_RGB);
    const vv_field_info vector = seed_info(VV_TYPE_F32, 3, VV_MEANING_VECTOR);
    const vv_field_info label = seed_info(VV_TYPE_U16, 1, VV_MEANING_LABEL);
    write_volume("nrrd", "rgb.nrrd", "raw", &rgb, 1, false);
    write_volume("nrrd", "vector.nrrd", "gzip", &vector, 2, true);
    write_volume("nrrd", "label.nrrd", "bzip2", &label, 1, false);
    write_volume("nifti", "rgb.nii", NULL, &rgb, 1, false);
    write_volume("nifti", "vector.nii", NULL, &vector, 2, true);
    write_volume("nifti", "label.nii", NULL, &label, 1, false);
    write_volume("metaimage", "rgb.mha", "raw", &rgb, 1, false);
    write_volume("metaimage", "vector.mha", "zlib", &vector, 2, true);
    write_volume("metaimage", "label.mha", "raw", &label, 1, false);
    write_volume("tiff", "rgb.ome.tif", "deflate", &rgb, 2, true);
    write_volume("tiff", "vector.ome.tif", "raw", &vector, 2, false);
    write_volume("npy", "rgb.npy", NULL, &rgb, 1, false);
    write_volume("npy", "vector.npy", NULL, &vector, 2, true);
#if VV_HAVE_HDF5
    write_volume("hdf5", "rgb.h5", NULL, &rgb, 1, false);
    write_volume("hdf5", "vector.h5", "raw", &vector, 2, true);
    write_volume("hdf5", "label.h5", "raw", &label, 1, false);
#endif
    vv_field_info wide = seed_info(VV_TYPE_U8, 1, VV_MEANING_SCALAR);
    wide.grid.dims[0] = 40000; /* the second version of NIfTI */
    wide.grid.dims[1] = wide.grid.dims[2] = 1;
    write_volume("nifti", "wide.nii", NULL, &wide, 1, false);
}

/* Two bytes that say how, then a coded stream: the volume files serve as such. */
static void write_sources(void)
{
    static const struct {
        const char *suffix;
        uint8_t coding;
    } codings[] = {{".raw", 0}, {".raw.gz", 1}, {".raw.bz2", 2}, {".raw.zst", 3}};
    const vv_field_info info = seed_info(VV_TYPE_U16, 1, VV_MEANING_SCALAR);
    for (size_t i = 0; i < 4; i++) {
        char name[64];
        uint8_t bytes[4096] = {codings[i].coding, 3};
        snprintf(name, sizeof name, "stream%s", codings[i].suffix);
        write_volume("source", name, NULL, &info, 2, false);
        FILE *file = fopen(path_of("source", name), "rb");
        const size_t n = file ? fread(bytes + 2, 1, sizeof bytes - 2, file) : 0;
        if (!file || fclose(file) != 0)
            stop(name);
        put("source", name, bytes, n + 2);
    }
}

static void write_dicoms(void)
{
    for (int kind = 0; kind < TEST_DICOMS; kind++) {
        size_t n;
        uint8_t *bytes = test_dicom_make((test_dicom)kind, NULL, &n);
        put("dicom", test_dicom_names[kind], bytes, n);
        free(bytes);
    }
}

static void write_headers(void)
{
    put_text("metaimage", "text.mha",
             "NDims: 2\nDimSize = 2 2\nElementType = MET_FLOAT\nElementSize = 1 2\n"
             "BinaryData = False\nElementDataFile = LOCAL\n1 2.5, nan -inf");
    put_text("metaimage", "end.mha",
             "NDims = 1\nDimSize = 4\nElementType = MET_USHORT_ARRAY\nHeaderSize = -1\n"
             "ElementByteOrderMSB = True\nElementDataFile = LOCAL\n01234567");
    put_text("metaimage", "list.mhd",
             "NDims = 3\nDimSize = 1 1 2\nElementType = MET_UCHAR\nElementDataFile = LIST\na\nb\n");
    put_text("metaimage", "pattern.mhd",
             "NDims = 3\nDimSize = 1 1 2\nElementType = MET_UCHAR\nCompressedData = True\n"
             "ElementDataFile = a%03d.raw 1 2 1\n");
    put_text("vvh", "one.vvh", "dims: 2 2 2\ntype: u8\nspacing: 1 2 3\nspace: LPS\nunit: mm\ndata: a.raw\n");
    put_text("vvh", "many.vvh",
             "# slices\ndims: 2 2 2\ntype: i16\nbyte order: big\norder: x y z\nskip: -1\ncoding: raw\n"
             "scale: 2\nmeaning: label\ndata: s%03d.raw 1 2 1\n");
    put_text("vvh", "list.vvh", "dims: 2 2\ntype: f32\ncomponents: 3\nmeaning: vector\nframes: 2\ndata:\na\nb\n");
    put_text("dat", "a.dat",
             "ObjectFileName:\ta.raw\nTaggedFileName:\t---\nResolution:\t2 2 2\nSliceThickness:\t1 1 2\n"
             "Format:\tUCHAR\nNbrTags:\t0\nObjectType:\tTEXTURE_VOLUME_OBJECT\nObjectModel:\tRGBA\n");
    static const char inr[] = "#INRIMAGE-4#{\nXDIM=2\nYDIM=2\nZDIM=1\nVDIM=1\nTYPE=signed fixed\nPIXSIZE=16 bits\n"
                              "SCALE=2**-2\nCPU=sun\nVX=1.5\n";
    char padded[264];
    memset(padded, '\n', sizeof padded);
    memcpy(padded, inr, sizeof inr - 1);
    memcpy(padded + 252, "##}\n", 4);
    put("inr", "a.inr", padded, sizeof padded);
    put_text("pvm", "plain.pvm", "PVM3\n2 2 1\n1 1 2\n2\n01234567what");
    static const uint8_t packed[] = {68,  68,  83,  32,  118, 51,  100, 10,  0,   1,   5,   125, 8,   103, 118, 85,
                                     138, 182, 89,  200, 139, 161, 92,  182, 241, 114, 145, 118, 232, 198, 225, 34,
                                     28,  86,  107, 189, 6,   234, 48,  32,  14,  129, 0,   86,  129, 3,   148, 1,
                                     208, 32,  64,  129, 200, 78,  128, 58,  4,   8,   16,  57,  64,  28,  0};
    put("pvm", "packed.pvm", packed, sizeof packed);
    put_text("slc", "plain.slc", "11111\n3 2 2 8\n1.500000 1 2\n1 6 0 0\n2 1 Xabcdef0123456789ab");
    put_text("slc", "coded.slc", "11111\n3 2 2 8\n1 1 1\n2 5 0 1\n0 0 X5 X\x83\1\2\3\6 6 X\4\x09\x82\5\6\6");
}

/* Headers of grids as text. */
static void write_grids(void)
{
    put_text(
        "vtr", "text.vtr",
        "<VTKFile type=\"RectilinearGrid\" byte_order=\"LittleEndian\"><RectilinearGrid WholeExtent=\"0 2 0 1 0 0\">"
        "<FieldData><DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" "
        "format=\"ascii\">2.5</DataArray>"
        "</FieldData><Piece Extent=\"0 2 0 1 0 0\"><Coordinates><DataArray type=\"Float32\" format=\"ascii\">0 1 3"
        "</DataArray><DataArray type=\"Float32\" format=\"ascii\">5 4</DataArray><DataArray type=\"Float32\" "
        "format=\"ascii\">7</DataArray></Coordinates><PointData Scalars=\"a\"><DataArray type=\"UInt8\" Name=\"a\" "
        "format=\"ascii\">1 2 3 4 5 6</DataArray></PointData></Piece></RectilinearGrid></VTKFile>");
    put_text(
        "vtk", "text.vtk",
        "# vtk DataFile Version 3.0\ntitle\nASCII\nDATASET RECTILINEAR_GRID\nDIMENSIONS 3 2 1\nX_COORDINATES 3 float\n"
        "0 1 3\nY_COORDINATES 2 float\n5 4\nZ_COORDINATES 1 float\n7\nPOINT_DATA 6\nSCALARS a%20b short "
        "1\nLOOKUP_TABLE "
        "default\n1 2 3 4 5 6\nMETADATA\nINFORMATION 0\n\nFIELD f 1\nx 1 6 float\n1 2 3 4 5 6\nCELL_DATA 2\nSCALARS c "
        "unsigned_char\nLOOKUP_TABLE default\n1 2\n");
    put_text("vtk", "bytes.vtk",
             "# vtk DataFile Version 2.0\nbytes\nBINARY\nDATASET STRUCTURED_POINTS\nDIMENSIONS 3 2 1\nORIGIN 0 0 "
             "0\nSPACING 1 "
             "1 1\nPOINT_DATA 6\nSCALARS a short\nLOOKUP_TABLE default\nabcdefghijkl\nVECTORS v unsigned_char\n"
             "abcdefghijklmnopqr\nCOLOR_SCALARS c 2\nabcdefghijkl\nLOOKUP_TABLE l 1\nabcd\n");
    put_text(
        "dx", "text.dx",
        "# c\nobject 1 class array type float rank 1 shape 2 items 6 text data follows\n1 2 3 4 5 6 7 8 9 10 11 12\n"
        "attribute \"dep\" string \"positions\"\nobject 2 class gridpositions counts 3 2 1\norigin 0 0 0\ndelta 1 0 0\n"
        "delta 0 1 0\ndelta 0 0 1\nobject \"f\" class field\ncomponent \"data\" value 1\ncomponent \"positions\" value "
        "2\n"
        "end\n");
    put_text("dx", "bytes.dx",
             "object 1 class array type short rank 0 items 6 lsb ieee data 0\nobject 2 class gridpositions counts 3 2\n"
             "object 3 class field\ncomponent \"data\" value 1\ncomponent \"positions\" value 2\nend\nabcdefghijkl");
    put_text("dx", "import.general",
             "file = g.bin\ngrid = 3 x 2 x 1\nformat = lsb binary\nfield = a, b\ntype = byte, byte\nstructure = "
             "scalar, scalar\nheader = bytes 2\npositions = 0, 1, 0, 1, 0, 1\nend\n");
    put_text("cube", "orbitals.cube",
             "t\nu\n -1 0.0 0.0 0.0\n 3 1.0 0.0 0.0\n 2 0.0 1.0 0.0\n 1 0.0 0.0 1.0\n 6 6.0 1.0 2.0 3.0\n 2 4 5\n1 2 3 "
             "4 5 6 7 8 9 "
             "10 11 12\n");
    put_text("vti", "lz4.vti",
             "<VTKFile type=\"ImageData\" byte_order=\"LittleEndian\" compressor=\"vtkLZ4DataCompressor\"><ImageData "
             "WholeExtent=\"0 1 0 1 0 0\"><Piece Extent=\"0 1 0 1 0 0\"><CellData><DataArray type=\"UInt8\" Name=\"a\" "
             "format=\"binary\">AQAAAAgAAAABAAAAAgAAAA==EEE=</DataArray></CellData></Piece></ImageData></VTKFile>");
}

/* Every mesh format in each of its encodings; what our writers never do. */
static void write_meshes(void)
{
    static const unsigned contents[] = {
        0, 5, 10, 15, TEST_MESH_PARTS | TEST_MESH_TEXTURES, TEST_MESH_PARTS | TEST_MESH_TEXTURES | TEST_MESH_CORNERS};
    const vv_mesh_format *const *formats = vv_registry_builtin()->mesh_formats;
    for (size_t f = 0; formats[f]; f++)
        for (size_t k = 0; k == 0 || (formats[f]->encodings && formats[f]->encodings[k]); k++)
            for (size_t i = 0; i < sizeof contents / sizeof *contents; i++) {
                char name[64];
                const unsigned with = contents[i];
                vv_mesh *mesh = test_mesh_strip(3, with);
                vv_mesh_write_options options;
                vv_mesh_write_options_init(&options, sizeof options);
                options.encoding = formats[f]->encodings ? formats[f]->encodings[k] : NULL;
                snprintf(name, sizeof name, "%zu-%u%s", k, with, formats[f]->suffixes[0]);
                if (!mesh || vv_mesh_write(path_of("mesh", name), mesh, &options, NULL) != VV_OK)
                    stop(name);
                vv_mesh_release(mesh);
            }
    put_text("mesh", "strips.ply",
             "ply\nformat ascii 1.0\nobj_info a b\nelement vertex 4\nproperty double x\nproperty short y\nproperty "
             "char z\nelement tristrips 1\nproperty list int int vertex_indices\nelement edge 1\nproperty int "
             "a\nend_header\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n6 0 1 2 3 -1 0\n7\n");
    put_text("mesh", "image.ply",
             "ply\nformat ascii 1.0\ncomment TextureFile a.png\nelement vertex 4\nproperty float x\nproperty float "
             "y\nproperty float z\nproperty float u\nproperty float v\nelement face 1\nproperty list uchar int "
             "vertex_indices\nproperty list uchar float texcoord\nproperty int texnumber\nend_header\n0 0 0 0 0\n1 0 "
             "0 1 0\n1 1 0 1 1\n0 1 0 0 1\n4 0 1 2 3 8 0 0 1 0 1 1 0 1 0\n");
    put_text(
        "mesh", "image.gltf",
        "{\"asset\":{\"version\":\"2.0\"},\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}],\"meshes\":[{"
        "\"primitives\":[{\"attributes\":{\"POSITION\":0,\"TEXCOORD_1\":1},\"material\":0}]}],\"materials\":[{"
        "\"alphaMode\":\"MASK\",\"alphaCutoff\":0.3,\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0,"
        "\"texCoord\":1,\"extensions\":{\"KHR_texture_transform\":{\"scale\":[2,3],\"offset\":[0.1,0.2],"
        "\"rotation\":1}}}}}],\"textures\":[{\"source\":0,\"sampler\":0}],\"samplers\":[{\"wrapS\":33648}],"
        "\"images\":[{\"uri\":\"data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVR42mP4"
        "z8AAAAMBAQDJ/pLvAAAAAElFTkSuQmCC\"}],\"accessors\":[{\"count\":3,\"componentType\":5126,\"type\":\"VEC3\"},"
        "{\"count\":3,\"componentType\":5126,\"type\":\"VEC2\"}]}");
    put_text("mesh", "concave.obj",
             "mtllib a.mtl\nv 0 0 0 1 0 0\nv 2 1 0\nv 0 2 0 1\nv 1 1 0\nvn 0 0 1\nvn 0 1 0\ng a b\nusemtl c\ns "
             "off\nf -4/1/1 \\\n -3//2 -2 4\nl 1 2\ng\nf 1 2 3\n");
    put_text("mesh", "color.off",
             "STCNOFF # c\n3 1 0 # d\n0 0 0 0 0 1 255 0 0 9 0 0\n1 0 0 0 0 1 0 255 0 9 0 0\n"
             "0 1 0 0 0 1 0 0 255 9 1 1\n3 0 1 2 0.5 0.5 0.5 1\n");
}

static void write_texts(void)
{
    put_text("seg_nrrd", "layers.seg.nrrd",
             "NRRD0004\ntype: uchar\ndimension: 4\nsizes: 2 2 2 1\nkinds: list domain domain domain\nencoding: raw\n"
             "space: LPS\nspace directions: none (1,0,0) (0,1,0) (0,0,2)\nmeasurement frame: (1,0,0) (0,1,0) (0,0,1)\n"
             "thicknesses: nan 1 1 nan\nlabels: \"\" \"x\" \"y\" \"z\"\nold min: 0\nSegment0_ID:=a\nSegment0_Layer:=0\n"
             "Segment0_LabelValue:=2\nSegment0_Name:=liver\nSegment0_Color:=0.5 0.25 1\nSegment0_Extent:=0 1 0 1 0 0\n"
             "Segment0_Tags:=k:v|TerminologyEntry:list~SCT^1^a~SCT^2^b~^^~list~SCT^3^c~^^|\nSegment1_ID:=b\n"
             "Segment1_Layer:=1\nSegment1_Tags:=TerminologyEntry:~^\nSegment1_LabelValue:=-1\n"
             "Segmentation_ReferenceImageExtentOffset:=1 2 -3\nSegmentation_ConversionParameters:=a|b|c&\n\n01020201");
    put_text("seg_nrrd", "plain.seg.nrrd",
             "NRRD0005\ntype: short\nendian: little\ndimension: 3\nsizes: 1 1 2\nencoding: raw\n\n0123");
    put_text(
        "nrrd", "dialects.nrrd",
        "NRRD0005\n# comment\ncontent: \"a\"\ntype: unsigned short int\ndimension: 4\nsizes: 2 2 2 2\nspace: LPS\n"
        "space directions: none (1,0,0) (0,0,-2) (0,1.5,0)\nspace origin: (1,2,3)\nspace units: \"mm\" \"mm\" \"mm\"\n"
        "kinds: list domain domain domain\ncenterings: ??? cell node cell\nlabels: \"c\" \"x\" \"y\" \"z\"\n"
        "measurement frame: (1,0,0) (0,1,0) (0,0,1)\nsample units: \"HU\"\nkey:=va\\nlue\nendian: big\nline skip: 1\n"
        "byte skip: 2\nencoding: raw\n\nskipped\nab0123456789abcdef0123456789abcdef");
    put_text("nrrd", "mins.nrrd",
             "NRRD0001\ntype: float\ndimension: 2\nsizes: 2 2\naxis mins: 0 1\naxis maxs: 3 nan\ncenters: node cell\n"
             "units: \"um\" \"um\"\nencoding: txt\n\n1 2.5, nan -inf");
    put_text("nrrd", "detached.nrrd",
             "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 1 1 2\nencoding: raw\ndata file: slice%03d.raw 1 2 1 2\n");
    put_text("nrrd", "list.nrrd",
             "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 1 1 2\nencoding: gz\ndata file: LIST 2\na.gz\nb.gz\n");
    put_text("raw", "u8", "2x2x2,u8\n01234567");
    put_text("raw", "all", "1x2x1x2,u16x2,spacing=1x1.5x2,big,skip=3\n...0123456789abcdef");
    put_text("scene", "empty", "{}");
    put_text("scene", "world",
             "{\"unit\": \"mm\", \"lights\": {\"key\": {\"kind\": \"point\", \"intensity\": 2}}, \"cut_planes\": "
             "[{\"offset\": \"2cm\"}], \"views\": {\"main\": {\"width\": 64}}}");
    put_text(
        "scene", "made",
        "{\"datasets\": {\"a\": {\"operation\": \"gaussian\", \"inputs\": {\"volume\": \"b\"}, \"parameters\": "
        "{\"sigma\": "
        "[\"1mm\", 2]}}, \"b\": {\"operation\": \"calc\", \"inputs\": {\"p\": \"a\", \"q\": \"c\"}, \"parameters\": "
        "\"{\\\"formula\\\": \\\"p+q\\\"}\"}, \"c\": {\"operation\": \"median\", \"source\": \"d\"}, \"d\": {}}}");
    put_text(
        "path", "sets",
        "lights.key.intensity=2\nviews.main.width=64\ncut_planes.0.offset=1.5mm\nunit=mm\nlights.key=null\n"
        "views.main.camera.fov=30deg\nbackground=1,0,0\ndatasets.a.operation=median\ndatasets.a.parameters.radius=1mm\n"
        "datasets.a.inputs={\"volume\": \"b\"}\ndatasets.a.inputs.volume=c\ndatasets.a.parameters.radius=null\n"
        "datasets.a.inputs.volume.x=1");
    static const char *const quantities[] = {"1.5mm", "30deg",   "2s",     "8G",  "50%",
                                             "3vox",  "-1e-300", "0.1rad", "inf", "1e400"};
    for (size_t i = 0; i < sizeof quantities / sizeof *quantities; i++) {
        char name[32], text[32];
        snprintf(name, sizeof name, "quantity%zu", i);
        snprintf(text, sizeof text, "%c%s", (int)('0' + i % 6), quantities[i]);
        put_text("unit", name, text);
        put_text("unit", quantities[i], quantities[i]);
    }
    put_text("expression", "signs", "-a^2 + !b * (c - 1e-3) % 2 / .5 >= x && y != i || a == b ? a < b : c <= 3");
    put_text("expression", "functions",
             "where(isnan(a), min(a, b, 1), clamp(hypot(x, y), 0, pi)) + atan2(y, x) * max(nan, inf) - log10(abs(a))");
}

/* One message of each type (docs/protocol.md), each after the greeting, and all of them; then what a journal may hold.
 */
/* What fuzz_checkpoint.c makes of the first byte. */
typedef struct way {
    const char *name;
    char bits;
    const char *samples, *noise, *adaptive, *method;
    int steps;
    bool coarse;
} way;

static void set_in(vv_world **world, const char *path, const char *json)
{
    vv_object *top = &(*world)->base;
    if (json && vv_path_set(&top, path, json, NULL) != VV_OK)
        stop(path);
    *world = (vv_world *)(void *)top;
}

static void write_checkpoint(const way *w, vv_world *world)
{
    static char bytes[1 << 16];
    vv_picture *picture;
    vv_picture_until until;
    const char *path = path_of("checkpoint", "seed.part");
    if (vv_picture_new(&picture, world, NULL, w->coarse, NULL) != VV_OK)
        stop(w->name);
    vv_picture_until_init(&until, sizeof until);
    until.seconds = 1e-9;
    for (int i = 0; i < w->steps; i++)
        if (vv_picture_step(picture, &until, NULL) != VV_OK)
            stop(w->name);
    if (vv_picture_save(picture, path, NULL) != VV_OK)
        stop(w->name);
    vv_picture_free(picture);
    FILE *file = fopen(path, "rb");
    const size_t n = file ? fread(bytes + 1, 1, sizeof bytes - 1, file) : 0;
    if (!n || fclose(file) != 0 || remove(path) != 0)
        stop(path);
    bytes[0] = (char)(w->bits | 32);
    put("checkpoint", w->name, bytes, n + 1);
}

static void write_checkpoints(void)
{
    static const way ways[] = {
        {"new", 0, "1", NULL, NULL, NULL, 0, false},
        {"whole", 0, "1", NULL, NULL, NULL, 9, false},
        {"grid", 0, "1", NULL, NULL, NULL, 2, true},
        {"squares", 4, "1", NULL, "true", NULL, 1, false},
        {"rays", 3, "9", "0.01", NULL, NULL, 4, false},
        {"judge", 1, "9", NULL, NULL, NULL, 4, false},
        {"draw", 16, "1", NULL, NULL, "\"surface\"", 0, false},
    };
    vv_field *field = test_field_cube(&test_form_sphere, 4, 0, 14, NULL);
    for (size_t i = 0; i < sizeof ways / sizeof *ways; i++) {
        vv_world *world;
        if (!field || vv_world_for_field(&world, "a", field, NULL) != VV_OK)
            stop("world");
        set_in(&world, "views.main.width", "9");
        set_in(&world, "views.main.height", "7");
        set_in(&world, "views.main.render.samples", ways[i].samples);
        set_in(&world, "views.main.render.noise", ways[i].noise);
        set_in(&world, "views.main.render.adaptive", ways[i].adaptive);
        set_in(&world, "views.main.render.method", ways[i].method);
        write_checkpoint(&ways[i], world);
        vv_object_release(&world->base);
    }
    vv_field_release(field);
}

static void write_sessions(void)
{
    static const char *const messages[] = {
        "{\"type\":\"hello\",\"width\":32,\"height\":24}",
        "{\"type\":\"size\",\"width\":24,\"height\":32}",
        "{\"type\":\"events\",\"lines\":\"0 mouse axis x 0\\n0 mouse button left down\\n8 mouse axis x 0.5\\n9 mouse "
        "lost\"}",
        "{\"type\":\"ack\",\"frame\":1}",
        "{\"type\":\"edit\",\"id\":1,\"gesture\":\"g\",\"edits\":[{\"op\":\"set\",\"path\":\"title\",\"value\":\"x\"},{"
        "\"op\":\"unset\",\"path\":\"title\"},{\"op\":\"add\",\"path\":\"lights\",\"id\":\"l\"},{\"op\":\"remove\","
        "\"path\":\"lights.l\"}]}",
        "{\"type\":\"edit\",\"id\":2,\"edits\":[{\"op\":\"set\",\"path\":\"background\",\"value\":\"#102030\"}]}",
        "{\"type\":\"undo\",\"id\":3}",
        "{\"type\":\"redo\",\"id\":4}",
        "{\"type\":\"action\",\"name\":\"isometric\"}",
        "{\"type\":\"camera\",\"eye\":[9,8,7],\"at\":[2,2,2],\"up\":[0,0,1],\"fov\":20}",
        "{\"type\":\"camera\",\"eye\":[9,8,7],\"at\":[2,2,2],\"up\":[0,0,1],\"parallel\":true,\"height\":3}",
        "{\"type\":\"browse\",\"id\":5,\"path\":\"\"}",
        "{\"type\":\"open\",\"id\":6,\"path\":\"ball.nrrd\",\"add\":true}",
        "{\"type\":\"sample\",\"id\":7,\"name\":\"ball\"}",
        "{\"type\":\"save\",\"id\":8,\"path\":\"kept\"}",
        "{\"type\":\"run\",\"id\":9,\"operation\":\"gaussian\",\"dataset\":\"ball\",\"parameters\":{\"sigma\":\"1vox\"}"
        "}",
        "{\"type\":\"cancel\",\"id\":10,\"job\":1}",
        "{\"type\":\"pick\",\"id\":11,\"x\":0.5,\"y\":0.5}",
        "{\"type\":\"histogram\",\"id\":12,\"volume\":\"ball\"}",
        "{\"type\":\"transfer\",\"id\":13,\"volume\":\"ball\"}",
        "{\"type\":\"picture\",\"id\":14,\"width\":8,\"height\":8,\"name\":\"p.png\"}",
        "{\"type\":\"command\",\"id\":15}",
        "{\"type\":\"describe\",\"id\":16}",
        "{\"type\":\"info\",\"id\":17,\"dataset\":\"ball\"}",
        "@{\"type\":\"hello\",\"width\":16,\"height\":16}",
        "@{\"type\":\"open\",\"id\":1,\"path\":\"../outside.vv.json\"}",
        "@{\"type\":\"save\",\"id\":2,\"path\":\"../outside\"}",
        "@{\"type\":\"browse\",\"id\":3,\"path\":\"..\"}",
        "@{\"type\":\"edit\",\"id\":4,\"edits\":[{\"op\":\"set\",\"path\":\"datasets.ball.path\",\"value\":\"/etc/"
        "passwd\"}]}",
    };
    static const char journal[] =
        "{\"who\":\"\",\"scene\":{\"unit\":\"mm\",\"views\":{\"main\":{}}}}\n{\"who\":\"main\",\"edits\":[{\"op\":"
        "\"set\",\"path\":"
        "\"title\",\"value\":\"x\"}],\"join\":false}\n{\"undo\":\"main\"}\n{\"redo\":\"main\"}\n{\"who\":\"ma";
    char all[8192] = "", text[2048];
    for (size_t i = 0; i < sizeof messages / sizeof *messages; i++) {
        char name[32];
        snprintf(name, sizeof name, "message%zu", i);
        snprintf(text, sizeof text, "%s\n%s\n", messages[0], messages[i]);
        put_text("session", name, text);
        const size_t n = strlen(all);
        snprintf(all + n, sizeof all - n, "%s\n", messages[i]);
    }
    put_text("session", "all", all);
    put("session", "journal", journal, sizeof journal); /* with its byte 0 */
}

static void write_requests(void)
{
    static const char upgrade[] =
        "GET /ws HTTP/1.1\r\nHost: localhost:8080\r\nOrigin: http://localhost:8080\r\nConnection: keep-alive, "
        "Upgrade\r\n"
        "Upgrade: websocket\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
        "Sec-WebSocket-Protocol: volvis\r\nCookie: volvis-8080=0123456789abcdef\r\n\r\n"
        "\x81\x85\x37\xfa\x21\x3d\x7f\x9f\x4d\x51\x58\x01\x83\x01\x02\x03\x04Hel\x89\x81\x01\x01\x01\x01p\x80\x82\x01"
        "\x01\x01\x01lo"
        "\x88\x82\x01\x01\x01\x01\x02\xe9";
    put_text("request", "page",
             "GET /app.js?x HTTP/1.1\r\nHost: localhost:8080\r\nSec-Fetch-Site: same-origin\r\n\r\n");
    put_text("request", "token",
             "POST /session HTTP/1.1\r\nHost: [::1]:8080\r\nContent-Length: 12\r\n\r\n{\"token\":\"\"}");
    put_text("request", "file",
             "PUT /files/%C3%A4.nrrd HTTP/1.1\r\nHost: a\r\nAuthorization: Bearer x\r\nContent-Length: 1\r\n\r\nx");
    put_text("request", "coded", "PUT / HTTP/1.1\r\nTransfer-Encoding: chunked\r\nContent-Length: 1\r\n\r\n");
    put("request", "upgrade", upgrade, sizeof upgrade - 1);
}

static void write_image(const char *target, const char *name, const vv_image *image, int bits, unsigned layers)
{
    vv_text text = {(char[]){"VolVis:Scene"}, (char[]){"{}"}};
    vv_image_options options;
    vv_image_options_init(&options, sizeof options);
    options.bits = bits;
    options.layers = layers;
    options.text = &text;
    options.n_text = 1;
    const vv_status st = vv_image_write(path_of(target, name), image, &options, NULL);
    if (st != VV_OK && st != VV_E_UNSUPPORTED) /* built without its library */
        stop(name);
}

static void write_images(void)
{
    const unsigned layers = (1u << VV_LAYER_COUNT) - 1;
    vv_image *image;
    if (vv_image_new(&image, 19, 18, layers, NULL) != VV_OK)
        stop("image");
    for (size_t i = 0; i < 19 * 18 * 4; i++)
        image->rgba[i] = i % 4 == 3 ? 1 : (float)test_random_unit(1, i);
    write_image("jpeg", "colour.jpg", image, 0, 0);
    write_image("tiff_image", "codes.tif", image, 8, 0);
    write_image("tiff_image", "wide.tif", image, 16, 0);
    write_image("tiff_image", "floats.tif", image, 32, 0);
    write_image("webp", "colour.webp", image, 0, 0);
    write_image("pdf", "colour.pdf", image, 0, 0);
    write_image("exr", "half.exr", image, 16, 0);
    write_image("exr", "layers.exr", image, 32, layers);
    write_image("pfm", "colour.pfm", image, 0, 0);
    write_image("pfm", "beside.pfm", image, 0, VV_LAYER_DEPTH);
    vv_image_release(image);
    put_text("pfm", "text", "Pf\n1 2\n1.0\n01234567");
    put_text("jpeg", "text", "\xff\xd8\xff\xfe");
    put_text("exr", "text", "v/1\001");
    put_text("webp", "text", "RIFF\x20   WEBPVP8 ");
    put_text("tiff_image", "text", "II*");
}

/* Metadata and a chunk in one: see fuzz_zarr.c. */
static void write_zarrs(void)
{
#define V3(codecs, fill)                                                                                               \
    "zarr.json\n{\"zarr_format\":3,\"node_type\":\"array\",\"shape\":[2,2,3],\"data_type\":\"uint16\",\"chunk_grid\":" \
    "{\"name\":\"regular\",\"configuration\":{\"chunk_shape\":[2,2,3]}},\"chunk_key_encoding\":{\"name\":\"default\"}" \
    ","                                                                                                                \
    "\"fill_value\":" fill ",\"codecs\":[" codecs "]}\n--\nabcdefghijklmnopqrstuvwx"
#define BYTES "{\"name\":\"bytes\",\"configuration\":{\"endian\":\"big\"}}"
    put_text("zarr", "v3-raw", V3(BYTES, "7"));
    put_text("zarr", "v3-transpose",
             V3("{\"name\":\"transpose\",\"configuration\":{\"order\":[2,0,1]}}," BYTES, "\"0x1234\""));
    put_text("zarr", "v3-gzip", V3(BYTES ",{\"name\":\"gzip\"},{\"name\":\"crc32c\"}", "0"));
    put_text("zarr", "v3-blosc", V3(BYTES ",{\"name\":\"blosc\"}", "0"));
    put_text("zarr", "v3-shard",
             V3("{\"name\":\"sharding_indexed\",\"configuration\":{\"chunk_shape\":[2,2,3],\"codecs\":[" BYTES
                "],\"index_codecs\":[" BYTES "],\"index_location\":\"start\"}}",
                "0"));
    put_text(
        "zarr", "v3-group",
        "zarr.json\n{\"zarr_format\":3,\"node_type\":\"group\",\"attributes\":{\"ome\":{\"multiscales\":[{\"axes\":"
        "[{\"name\":\"y\"},{\"name\":\"x\"}],\"datasets\":[{\"path\":\"0\"}]}]}}}\n--\n");
    put_text("zarr", "v2-raw",
             ".zarray\n{\"zarr_format\":2,\"shape\":[2,2,3],\"chunks\":[2,2,3],\"dtype\":\"<f2\",\"order\":\"F\","
             "\"fill_value\":\"NaN\",\"filters\":[{\"id\":\"shuffle\",\"elementsize\":2}],\"compressor\":null}\n--\n"
             "abcdefghijklmnopqrstuvwx");
    put_text("zarr", "v2-lz4",
             ".zarray\n{\"zarr_format\":2,\"shape\":[2,2,3],\"chunks\":[2,2,3],\"dtype\":\"<i4\",\"order\":\"C\","
             "\"fill_value\":null,\"filters\":[{\"id\":\"delta\",\"dtype\":\"<i4\"}],\"compressor\":{\"id\":\"lz4\"}}\n"
             "--\nabcdefghijklmnopqrstuvwx");
#undef V3
#undef BYTES
}

int main(int argc, char **argv)
{
    if (argc != 2) {
        fprintf(stderr, "make_corpus FOLDER\n");
        return 2;
    }
    root = argv[1];
    if (mkdir(root, 0755) != 0 && errno != EEXIST)
        stop(root);
    write_volumes();
    write_sources();
    write_images();
    write_sessions();
    write_checkpoints();
    write_requests();
    write_dicoms();
    write_headers();
    write_texts();
    write_meshes();
    write_grids();
    write_zarrs();
    return 0;
}
