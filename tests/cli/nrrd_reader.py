"""A reader of NRRD written from its definition (https://teem.sourceforge.net/nrrd/format.html), for files with attached
data. It knows nothing of what axes mean."""
import bz2
import gzip

import numpy

TYPES = {"uint8": "u1", "unsigned char": "u1", "uchar": "u1", "int8": "i1", "int16": "i2", "short": "i2", "uint16": "u2",
         "unsigned short": "u2", "int32": "i4", "int": "i4", "uint32": "u4", "uint64": "u8", "int64": "i8", "float": "f4",
         "double": "f8"}


class Nrrd:
    """fields, keys (in their order), comments, and data by index, the fastest axis first."""

    def __init__(self, path):
        with open(path, "rb") as file:
            head, _, data = file.read().partition(b"\n\n")
        lines = head.decode("utf-8").split("\n")
        assert lines[0].startswith("NRRD000")
        self.fields, self.keys, self.comments = {}, {}, []
        for line in lines[1:]:
            if line.startswith("#"):
                self.comments.append(line[1:].strip())
            elif ":=" in line and (": " not in line or line.index(":=") < line.index(": ")):
                key, _, value = line.partition(":=")
                assert key not in self.keys, key
                self.keys[key] = value.replace("\\n", "\n").replace("\\\\", "\\")
            else:
                field, _, value = line.partition(": ")
                assert field not in self.fields, field
                self.fields[field] = value.strip()
        encoding = self.fields["encoding"]
        if encoding == "gzip":
            data = gzip.decompress(data)
        elif encoding == "bzip2":
            data = bz2.decompress(data)
        sizes = [int(n) for n in self.fields["sizes"].split()]
        assert len(sizes) == int(self.fields["dimension"])
        kind = TYPES[self.fields["type"]]
        if encoding == "ascii":
            flat = numpy.array(data.split(), dtype=kind)
        else:
            assert encoding in ("raw", "gzip", "bzip2")
            order = ">" if self.fields.get("endian") == "big" else "<"
            flat = numpy.frombuffer(data, dtype=order + kind)
        self.data = flat.reshape(sizes, order="F")

    def vectors(self, field):
        """Of `space directions` and its like: a tuple of numbers each, None for none."""
        return [None if word == "none" else tuple(float(x) for x in word.strip("()").split(","))
                for word in self.fields[field].split()]

    def segments(self):
        """What the keys of each segment say, by number."""
        out = []
        while f"Segment{len(out)}_ID" in self.keys:
            start = f"Segment{len(out)}_"
            out.append({key[len(start):]: value for key, value in self.keys.items() if key.startswith(start)})
        assert not any(key.startswith(f"Segment{len(out)}_") for key in self.keys)
        return out


def write(path, data, fields, keys=(), comments=(), magic="NRRD0005"):
    """data by index, the fastest axis first; fields and keys: pairs."""
    kinds = {"u1": "uint8", "i2": "int16", "u2": "uint16", "f4": "float", "i4": "int32"}
    name = kinds[data.dtype.str[1:]]
    lines = [magic, *("# " + text for text in comments), f"type: {name}", f"dimension: {data.ndim}",
             "sizes: " + " ".join(map(str, data.shape)), "encoding: raw", "endian: little"]
    lines += [f"{name}: {value}" for name, value in fields] + [f"{key}:={value}" for key, value in keys]
    with open(path, "wb") as file:
        file.write("\n".join(lines).encode("utf-8") + b"\n\n" + data.astype(data.dtype.newbyteorder("<")).tobytes(order="F"))
