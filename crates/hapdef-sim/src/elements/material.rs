//! Isotropic linear elasticity.

use crate::SimError;

/// An isotropic linear-elastic material, σ = λ tr(ε) I + 2μ ε.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IsotropicMaterial {
    youngs_modulus_pa: f64,
    poissons_ratio: f64,
    density_kg_m3: f64,
}

/// Elements of a material of their own.
#[derive(Clone, Debug, PartialEq)]
pub struct MaterialRegion {
    /// The elements, counted from 0; a later region wins.
    pub elements: Vec<usize>,
    /// What they are made of.
    pub material: IsotropicMaterial,
}

impl IsotropicMaterial {
    /// The material with modulus `youngs_modulus_pa` (E), ratio `poissons_ratio` (ν) and density.
    ///
    /// # Errors
    /// [`SimError::Material`] unless E and the density are finite and positive and −1 < ν < ½,
    /// ends excluded: the range in which the strain energy is positive.
    pub fn new(
        youngs_modulus_pa: f64,
        poissons_ratio: f64,
        density_kg_m3: f64,
    ) -> Result<Self, SimError> {
        let positive = |value: f64| value.is_finite() && value > 0.0;
        let check = |ok: bool, property, value, expected| {
            if ok { Ok(()) } else { Err(SimError::Material { property, value, expected }) }
        };
        check(
            positive(youngs_modulus_pa),
            "Young's modulus (Pa)",
            youngs_modulus_pa,
            "finite and positive",
        )?;
        check(
            poissons_ratio > -1.0 && poissons_ratio < 0.5,
            "Poisson's ratio",
            poissons_ratio,
            "above -1 and below 0.5",
        )?;
        check(positive(density_kg_m3), "density (kg/m³)", density_kg_m3, "finite and positive")?;
        Ok(Self { youngs_modulus_pa, poissons_ratio, density_kg_m3 })
    }

    /// Young's modulus E, Pa.
    #[must_use]
    pub fn youngs_modulus_pa(&self) -> f64 {
        self.youngs_modulus_pa
    }

    /// Poisson's ratio ν.
    #[must_use]
    pub fn poissons_ratio(&self) -> f64 {
        self.poissons_ratio
    }

    /// Density, kg/m³.
    #[must_use]
    pub fn density_kg_m3(&self) -> f64 {
        self.density_kg_m3
    }

    /// Lamé's first constant λ = E ν / ((1 + ν)(1 − 2ν)), Pa.
    #[must_use]
    pub fn lame_lambda_pa(&self) -> f64 {
        let nu = self.poissons_ratio;
        self.youngs_modulus_pa * nu / ((1.0 + nu) * (1.0 - 2.0 * nu))
    }

    /// The shear modulus μ = E / (2(1 + ν)), Pa.
    #[must_use]
    pub fn shear_modulus_pa(&self) -> f64 {
        self.youngs_modulus_pa / (2.0 * (1.0 + self.poissons_ratio))
    }
}
