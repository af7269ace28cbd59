"""Opens the fields of tests/e2e/write_fields.cpp with ParaView: an image in the plane with every array, at its place.
Usage, under a display: pvpython read_fields.py DIR"""
import math
import os
import sys

from paraview import servermanager, simple

ARRAYS = {"solid_fraction": 1, "velocity": 3, "gradient": 4, "shear_rate": 1, "shear_strain": 1}
SPACING, RATE, SECONDS = 2.0, 0.1, 10.0  # four radii of 0.5 m; as write_fields.cpp shears


def main(folder):
    source = simple.OpenDataFile(os.path.join(folder, "fields/fields-00000100.hdf"))
    assert source.GetXMLLabel() == "VTKHDF Reader", source.GetXMLLabel()
    source.UpdatePipeline()
    image = servermanager.Fetch(source)
    assert image.IsA("vtkImageData"), image.GetClassName()
    assert image.GetSpacing() == (SPACING, SPACING, SPACING), image.GetSpacing()
    # Grains lie in x from 0 to 58 and in y from 0 to 29; the grid is a spacing wider, in two layers.
    assert image.GetDimensions() == (32, 18, 2), image.GetDimensions()
    assert image.GetOrigin() == (-2.0, -2.0, -SPACING), image.GetOrigin()
    arrays = image.GetPointData()
    for name, components in ARRAYS.items():
        array = arrays.GetArray(name)
        assert array is not None, name
        assert array.GetNumberOfComponents() == components, (name, array.GetNumberOfComponents())
        assert array.GetNumberOfTuples() == image.GetNumberOfPoints(), name

    node = image.FindPoint(22.0, 14.0, 0.0)  # in the middle of the parallelogram
    assert image.GetPoint(node) == (22.0, 14.0, 0.0), image.GetPoint(node)
    v = arrays.GetArray("velocity").GetTuple3(node)
    assert math.isclose(v[0], RATE * 14, rel_tol=0.01) and abs(v[1]) < 1e-3 and v[2] == 0, v
    assert math.isclose(arrays.GetArray("gradient").GetTuple4(node)[1], RATE, rel_tol=0.02)
    assert math.isclose(arrays.GetArray("shear_strain").GetValue(node), RATE * SECONDS, rel_tol=0.02)
    assert math.isnan(arrays.GetArray("shear_rate").GetValue(0))  # a corner outside the material
    print("a VTKHDF image read:", ", ".join(ARRAYS))


main(sys.argv[1])
