"""Reads the run of tests/e2e/write_run.cpp with ParaView: the series of grains and of contacts through XDMF, and each
frame through the VTKHDF reader. Usage, under a display: pvpython read_xdmf.py DIR"""
import math
import os
import sys

from paraview import servermanager, simple

GRAIN_ARRAYS = {"id", "velocity", "spin", "rotation", "radius", "layer", "coordination", "pressure", "rank"}
CONTACT_ARRAYS = {"lo", "hi", "wall", "normal", "gap", "r_n", "r_t", "status"}


def n_contacts(n):
    return n - 1 + (n + 2) // 3


def fetch(source, time):
    source.UpdatePipeline(time)
    data = servermanager.Fetch(source)
    return data.GetBlock(0) if data.IsA("vtkMultiBlockDataSet") else data


def check_arrays(data, expected, n, what):
    assert data.GetNumberOfPoints() == n, (what, data.GetNumberOfPoints(), n)
    assert data.GetNumberOfCells() == n, (what, data.GetNumberOfCells(), n)
    arrays = data.GetPointData()
    found = {arrays.GetArrayName(i) for i in range(arrays.GetNumberOfArrays())}
    assert expected <= found, (what, expected - found)
    for name in expected:
        assert arrays.GetArray(name).GetNumberOfTuples() == n, (what, name)


def check_grains(data, n, what):
    check_arrays(data, GRAIN_ARRAYS, n, what)
    arrays = data.GetPointData()
    low, high = arrays.GetArray("radius").GetRange()
    # The formula gives these two numbers to the last bit; ParaView may hold them in single precision.
    assert math.isclose(low, 0.42, rel_tol=1e-7) and math.isclose(high, 0.42 + 0.01 * 14, rel_tol=1e-7), (what, low, high)
    last = n - 1
    assert arrays.GetArray("id").GetValue(last) == last, what
    assert arrays.GetArray("layer").GetValue(last) == 1 + last % 9, what
    x = data.GetPoint(last)
    assert math.isclose(x[0], last / 3, rel_tol=1e-6) and math.isclose(x[1], -last / 7, rel_tol=1e-6), (what, x)
    velocity = arrays.GetArray("velocity").GetTuple3(last)
    assert math.isclose(velocity[0], 0.1 * last, rel_tol=1e-6), (what, velocity)


def main(folder):
    os.chdir(folder)
    grains = simple.OpenDataFile("./run.xdmf")  # "./", or ParaView 5.11 looks for files beside it by wrong names
    assert list(grains.TimestepValues) == [0.0, 6.25, 12.5], grains.TimestepValues
    for k, time in enumerate(grains.TimestepValues):
        check_grains(fetch(grains, time), 100 + 10 * k, f"run.xdmf at {time}")

    contacts = simple.OpenDataFile("./contacts.xdmf")
    assert list(contacts.TimestepValues) == [0.0, 12.5], contacts.TimestepValues
    for k, time in ((0, 0.0), (2, 12.5)):
        n = 100 + 10 * k
        data = fetch(contacts, time)
        check_arrays(data, CONTACT_ARRAYS, n_contacts(n), f"contacts.xdmf at {time}")
        low, high = data.GetPointData().GetArray("r_n").GetRange()
        assert low == 0 and math.isclose(high, 5 * (n - 1 - (n - 1) % 3), rel_tol=1e-6), (low, high)

    for k in range(3):
        name = f"./frames/frame-{250 * k:08}.hdf"
        frame = simple.OpenDataFile(name)
        assert frame.GetXMLLabel() == "VTKHDF Reader", frame.GetXMLLabel()  # not one of the other readers of HDF5
        check_grains(fetch(frame, 0), 100 + 10 * k, name)
    print("run.xdmf, contacts.xdmf and three VTKHDF frames read")


main(sys.argv[1])
