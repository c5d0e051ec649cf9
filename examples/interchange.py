#!/usr/bin/env python3
"""A mesh in Open3D and in trimesh, and back: interchange.py MESH.ply

Exits with 77, and says so, where neither library is installed.
"""

import sys

import numpy as np

import plumbline

mesh = plumbline.Mesh.load(sys.argv[1])
done = []

try:
    import open3d
except ImportError:
    print("Open3D is not installed (Debian: python3-open3d)")
else:
    theirs = open3d.geometry.TriangleMesh(open3d.utility.Vector3dVector(mesh.vertices.astype(np.float64)),
                                          open3d.utility.Vector3iVector(mesh.triangles.astype(np.int32)))
    if len(mesh.colors):
        theirs.vertex_colors = open3d.utility.Vector3dVector(mesh.colors / 255.0)
    theirs.compute_vertex_normals()
    back = plumbline.Mesh(np.asarray(theirs.vertices), np.asarray(theirs.triangles), np.asarray(theirs.vertex_normals))
    np.testing.assert_allclose(back.vertices, mesh.vertices)
    print(f"Open3D: {theirs}")
    done.append("open3d")

try:
    import trimesh
except ImportError:
    print("trimesh is not installed (not in Debian 12; pip install trimesh)")
else:
    theirs = trimesh.Trimesh(mesh.vertices, mesh.triangles, vertex_normals=mesh.normals if len(mesh.normals) else None,
                             process=False)
    back = plumbline.Mesh(theirs.vertices, theirs.faces, theirs.vertex_normals)
    np.testing.assert_allclose(back.vertices, mesh.vertices)
    print(f"trimesh: {theirs}, area {theirs.area:.2f} m2")
    done.append("trimesh")

sys.exit(0 if done else 77)
