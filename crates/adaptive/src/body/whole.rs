//! A body itself in a contact: its own elements, and its whole surface as the zone (theory
//! section C.9).

pub mod indentation;

use std::borrow::Cow;
use std::sync::Arc;

use faer::{Mat, MatRef};
use ffr_dynamics::body::AssembledBody;

use super::field::Field;
use super::field_body::FieldBody;
use super::fine::FineModel;
use crate::adaptivity::interval::IntervalGrid;
use crate::body::fine::refined::{gigabytes, most_gigabytes};
use crate::body::splines::{Discretised, ElasticBody};
use crate::body::zone::{ContactZone, PointsAbout, WholeRequest};
use crate::error::{AdaptiveError, ContactModelFault};
use crate::record::{TargetPlace, ZoneSite, ZoneSize};
use crate::spec::{IntervalSpec, PointRule};
use crate::store::Bytes;

/// The body with what of its surface is the zone.
struct WholeBody {
    body: Arc<dyn FieldBody>,
    request: WholeRequest,
}

/// The model of `body` for a contact at `site`: refined about it with the settings `interval`, or
/// its own elements with their whole surface if that is what `site` says.
///
/// # Errors
/// [`AdaptiveError`] with the body's name if it cannot be refined so far.
pub fn fine_model(
    body: &Arc<dyn FieldBody>,
    site: &ZoneSite,
    interval: &IntervalSpec,
) -> Result<Box<dyn FineModel>, AdaptiveError> {
    if let ZoneSize::Interval { widths, finer } = site.size {
        return Arc::clone(body).refined(site, (widths, finer), interval);
    }
    let about = PointsAbout::of(body.undeformed(), site);
    let request = WholeRequest { about, part: site.part };
    Ok(Box::new(WholeBody { body: Arc::clone(body), request }))
}

impl FineModel for WholeBody {
    fn field(&self) -> &dyn Field {
        self.body.as_ref()
    }

    fn zone(&self, _rule: PointRule, contact: &str) -> Result<ContactZone, AdaptiveError> {
        let mut zone = self.body.whole_zone(&self.request, contact)?;
        if let Some(about) = self.request.about.as_ref().filter(|about| about.meets.is_some()) {
            zone.add_left_out(self.body.as_ref(), about);
        }
        let (all, unknowns) = (self.body.n_unknowns() as f64, zone.unknowns.len());
        let gigabytes = gigabytes(self.body.space().dimension(), all, unknowns as f64);
        let most = most_gigabytes();
        if gigabytes > most {
            let body = self.body.name().to_owned();
            let fault = ContactModelFault::LargeSurface { body, unknowns, gigabytes, most };
            return Err(AdaptiveError::ContactModel { contact: contact.to_owned(), fault });
        }
        Ok(zone)
    }

    fn grid(&self) -> IntervalGrid {
        IntervalGrid::of_whole(self.body.size())
    }

    fn contact_elements(&self, zone: &ContactZone) -> Vec<[usize; 2]> {
        vec![[0; 2]; zone.points.len()]
    }

    fn assemble(&self) -> Result<Cow<'_, AssembledBody>, AdaptiveError> {
        Ok(Cow::Borrowed(self.body.assembled()))
    }

    fn prolong(&self, shapes: MatRef<'_, f64>) -> Mat<f64> {
        shapes.to_owned()
    }

    fn definition(&self) -> Bytes {
        Bytes(self.body.definition())
    }

    fn meets(&self) -> Option<&TargetPlace> {
        self.request.about.as_ref()?.meets.as_ref()
    }

    fn is_own(&self) -> bool {
        true
    }

    fn faces(&self) -> Option<Discretised<'_>> {
        self.body.splines().map(ElasticBody::discretised)
    }
}
