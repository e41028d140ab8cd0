// A hanging serpentine spring: a strip 10 mm thick and 16 mm wide that runs from a clamped foot
// down through three hairpin bends to a free end block. Lengths in metres.
//
//   gmsh -3 -format msh41 serpentine_spring.geo -o serpentine_spring.msh
SetFactory("OpenCASCADE");

t = 0.010;   // thickness of the strip
w = 0.016;   // width, along z
r = 0.016;   // radius of the bends' centre line
l = 0.090;   // straight runs
h = 0.0051;  // element size

// Four straight runs along x, 2 r apart, downward.
For i In {0 : 3}
  Rectangle(1 + i) = {0, -2 * r * i - t / 2, 0, l, t};
EndFor

// Three bends: half rings at x = l, 0, l.
For i In {0 : 2}
  right = (i != 1);
  x = right ? l : 0;
  y = -r * (2 * i + 1);
  Disk(11 + 10 * i) = {x, y, 0, r + t / 2};
  Disk(12 + 10 * i) = {x, y, 0, r - t / 2};
  BooleanDifference(13 + 10 * i) = { Surface{11 + 10 * i}; Delete; }{ Surface{12 + 10 * i}; Delete; };
  Rectangle(14 + 10 * i) = {right ? x : x - 2 * r, y - 2 * r, 0, 2 * r, 4 * r};
  BooleanIntersection(15 + 10 * i) = { Surface{13 + 10 * i}; Delete; }{ Surface{14 + 10 * i}; Delete; };
EndFor

// Foot at the beginning of the first run; block with rounded corners at the end of the last.
Rectangle(51) = {-0.020, -t / 2 - 0.006, 0, 0.020, t + 0.012};
Rectangle(52) = {-0.028, -6 * r - 0.014, 0, 0.028, 0.028, 0.005};

BooleanUnion(60) = { Surface{1}; Delete; }{ Surface{2:4}; Surface{15}; Surface{25}; Surface{35}; Surface{51}; Surface{52}; Delete; };
out[] = Extrude {0, 0, w} { Surface{60}; };

eps = 1e-5;
clamp[] = Surface In BoundingBox{-0.020 - eps, -r, -eps, -0.020 + eps, r, w + eps};
tip[] = Surface In BoundingBox{-0.028 - eps, -6 * r - 0.02, -eps, -0.028 + eps, -6 * r + 0.02, w + eps};
Physical Volume("body") = {out[1]};
Physical Surface("clamp") = {clamp[]};
Physical Surface("tip") = {tip[]};

Mesh.MeshSizeMin = h;
Mesh.MeshSizeMax = h;
Mesh.Algorithm = 6;
Mesh.Optimize = 1;
