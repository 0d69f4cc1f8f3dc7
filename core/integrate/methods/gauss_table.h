/* The coefficients of the Gauss-Legendre collocation of 8 stages, order 16, computed with 60
 * digits and rounded.
 * Leaves to others: steps (kernel_symplectic).
 * Invariant: through[j][i] + through[i][j] is exactly 1, so that the map is symplectic; through[7 -
 * j][7 - i] equals through[i][j], so that it is symmetric. */
#pragma once

enum { GAUSS_STAGES = 8 };

/* weights b_j, in pairs, because b_j = b_{7 - j} */
static const double gauss_weight[GAUSS_STAGES] = {
    0x1.9ea1d04ca0374p-5, 0x1.c76fb531d2b96p-4, 0x1.413c50a255615p-3, 0x1.736360b199343p-3,
    0x1.736360b199343p-3, 0x1.413c50a255615p-3, 0x1.c76fb531d2b96p-4, 0x1.9ea1d04ca0374p-5};

/* a_ij / b_j as [j][i]: the contribution of stage j to stage i, relative to its contribution to the
 * whole step */
static const _Alignas(64) double gauss_through[GAUSS_STAGES][GAUSS_STAGES] = {
    {0x1.0000000000000p-1, 0x1.14f7117c3edf9p+0, 0x1.eb7f85d1a91e8p-1, 0x1.0654235bbce3ep+0,
     0x1.f74ee62646f0cp-1, 0x1.03213ccd47c31p+0, 0x1.fb854ecfadc92p-1, 0x1.016752422346fp+0},
    {-0x1.4f7117c3edf90p-4, 0x1.0000000000000p-1, 0x1.1642f0a7f7a89p+0, 0x1.e8fd7a0891d3ap-1,
     0x1.075cccf71ab6cp+0, 0x1.f5c050a6e22f4p-1, 0x1.039a60824198cp+0, 0x1.fb854ecfadc92p-1},
    {0x1.4807a2e56e180p-5, -0x1.642f0a7f7a890p-4, 0x1.0000000000000p-1, 0x1.168d515c5598cp+0,
     0x1.e85d000cd4e32p-1, 0x1.07941e92a625ep+0, 0x1.f5c050a6e22f4p-1, 0x1.03213ccd47c31p+0},
    {-0x1.9508d6ef38f80p-6, 0x1.70285f76e2c60p-5, -0x1.68d515c5598c0p-4, 0x1.0000000000000p-1,
     0x1.169deb67a9416p+0, 0x1.e85d000cd4e32p-1, 0x1.075cccf71ab6cp+0, 0x1.f74ee62646f0cp-1},
    {0x1.16233b3721e80p-6, -0x1.d7333dc6adb00p-6, 0x1.7a2fff32b1ce0p-5, -0x1.69deb67a94160p-4,
     0x1.0000000000000p-1, 0x1.168d515c5598cp+0, 0x1.e8fd7a0891d3ap-1, 0x1.0654235bbce3ep+0},
    {-0x1.909e66a3e1880p-7, 0x1.47f5eb23ba180p-6, -0x1.e507a4a989780p-6, 0x1.7a2fff32b1ce0p-5,
     -0x1.68d515c5598c0p-4, 0x1.0000000000000p-1, 0x1.1642f0a7f7a89p+0, 0x1.eb7f85d1a91e8p-1},
    {0x1.1eac4c148db80p-7, -0x1.cd304120cc600p-7, 0x1.47f5eb23ba180p-6, -0x1.d7333dc6adb00p-6,
     0x1.70285f76e2c60p-5, -0x1.642f0a7f7a890p-4, 0x1.0000000000000p-1, 0x1.14f7117c3edf9p+0},
    {-0x1.6752422346f00p-8, 0x1.1eac4c148db80p-7, -0x1.909e66a3e1880p-7, 0x1.16233b3721e80p-6,
     -0x1.9508d6ef38f80p-6, 0x1.4807a2e56e180p-5, -0x1.4f7117c3edf90p-4, 0x1.0000000000000p-1},
};

/* extrapolation of stage j to every stage of the next step, with the polynomial through all stages,
 * as [j][i] */
static const _Alignas(64) double gauss_onward[GAUSS_STAGES][GAUSS_STAGES] = {
    {-0x1.82329d5f34ec4p-4, -0x1.22b73af4b84e0p+1, -0x1.f717a974ac986p+4, -0x1.fda9b043cebbap+7,
     -0x1.2fc297bf7039fp+10, -0x1.a979f561d6039p+11, -0x1.4ffda07d2a01dp+12,
     -0x1.db1e781d555e2p+11},
    {0x1.3361b20787318p-3, 0x1.cbac9bad81d55p+1, 0x1.8a26335edad61p+5, 0x1.8bc8b41061b56p+8,
     0x1.d45a9d794abefp+10, 0x1.4640dee3d5325p+12, 0x1.00b94397f0080p+13, 0x1.6a57173b7ba9dp+12},
    {-0x1.ab62f127152dep-3, -0x1.3b1a33b49fae2p+2, -0x1.09385097e3a8fp+6, -0x1.05ad102eca2aep+9,
     -0x1.314e24a52cf82p+11, -0x1.a50276dce1863p+12, -0x1.49144cb0cb7f0p+13,
     -0x1.ced16638f2149p+12},
    {0x1.25dd1d4ecdec1p-2, 0x1.a624d5f6ac04bp+2, 0x1.57d16e8a841c5p+6, 0x1.494c89619cafcp+9,
     0x1.778125d94cacdp+11, 0x1.fd8e1aa2944e6p+12, 0x1.8a3a2a704a79cp+13, 0x1.13bc3d44b8bbap+13},
    {-0x1.a3c4db620896fp-2, -0x1.1eff3734c2583p+3, -0x1.b9851a80b4c96p+6, -0x1.9345f42bac547p+9,
     -0x1.bc62904fac0c4p+11, -0x1.26afad4d4a2b9p+13, -0x1.c19289decf03dp+13,
     -0x1.382a22166720ep+13},
    {0x1.454246e523dccp-1, 0x1.91dd8f36b325fp+3, 0x1.177e00b8dbb45p+7, 0x1.dab6ab9a27423p+9,
     0x1.f2dc4676e4159p+11, 0x1.4121c52b9650fp+13, 0x1.e15ff788dd055p+13, 0x1.4b4e6c7e47847p+13},
    {-0x1.224fef86b8ea9p+0, -0x1.1a961c1b11aadp+4, -0x1.4a2c36ce4b18bp+7, -0x1.fb0c48aec7e45p+9,
     -0x1.f73c4f46b39d6p+11, -0x1.397718c6295a9p+13, -0x1.cd3f31238df3dp+13,
     -0x1.3a9650a42974cp+13},
    {0x1.2feb567c6b18dp+1, 0x1.43804febcff5cp+4, 0x1.29c88193ed16dp+7, 0x1.9d33c81db5146p+9,
     0x1.865ca31763194p+11, 0x1.d9c58b31f53eep+12, 0x1.57b19c9515f5cp+13, 0x1.d1af7ccd18f39p+12},
};
